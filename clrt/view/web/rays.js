// --- a pixel's rays, in three dimensions and as a list

const hull = points => {
  // Andrew's monotone chain (1979)
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = list => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1) {
        const a = chain[chain.length - 2], b = chain[chain.length - 1];
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
};

const marked = colour => {
  const mark = make("span", { className: "mark" });
  mark.style.background = colour;
  return mark;
};

class Rays {
  constructor() {
    this.canvas = make("canvas", { tabIndex: 0, role: "img", className: "rays3d",
      "aria-label": "The rays in three dimensions. Arrow keys turn them, plus and minus zoom." });
    this.about = make("p", { className: "value" });
    this.list = make("div", { className: "tree" });
    this.key = make("p", { className: "key" });
    const views = [["front", 0, 0], ["side", Math.PI / 2, 0], ["top", 0, Math.PI / 2]].map(([name, yaw, pitch]) =>
      button(name, () => this.look(yaw, pitch, 1)));
    this.root = make("div", { hidden: true, className: "rays" },
      make("div", {}, this.about, this.canvas, make("div", { className: "row" }, ...views), this.key), this.list);
    this.look(0.6, 0.35, 1);
    this.listen();
  }

  look(yaw, pitch, zoom) {
    Object.assign(this, { yaw, pitch: clamp(pitch, -Math.PI / 2, Math.PI / 2), zoom: clamp(zoom, 0.2, 50) });
    this.draw();
  }

  listen() {
    const { canvas } = this;
    this.watch = new ResizeObserver(() => this.draw());
    this.watch.observe(canvas);
    canvas.addEventListener("pointerdown", event => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", event => {
      if (event.buttons) this.look(this.yaw - event.movementX / 120, this.pitch + event.movementY / 120, this.zoom);
    });
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      this.look(this.yaw, this.pitch, this.zoom * Math.exp(-event.deltaY / 500));
    }, { passive: false });
    canvas.addEventListener("keydown", event => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      const factor = { "+": 1.2, "-": 1 / 1.2 }[event.key] ?? 1;
      if (!step && factor === 1) return;
      event.preventDefault();
      this.look(this.yaw + (step?.[0] ?? 0), this.pitch + (step?.[1] ?? 0), this.zoom * factor);
    });
  }

  show(tree) {
    this.tree = tree;
    this.chosen = null;
    const [value, samples] = [tree.value.map(v => v.toPrecision(4)).join(" "), tree.samples];
    this.about.replaceChildren(make("strong", {}, `pixel (${tree.x}, ${tree.y}): ${value}`),
      ` ${tree.summary}`, tree.left_out ? `; ${tree.left_out} rays of later generations are left out` : "");
    this.root.dataset.samples = samples;
    const words = { light: "feeler that arrives", blocked: "feeler that does not" };
    this.key.replaceChildren(...Object.entries(tree.colours).map(([kind, colour]) => {
      return make("span", {}, marked(colour), `${words[kind] ?? kind} `);
    }));
    this.build(tree);
    this.root.hidden = false;
    this.draw();
  }

  build(tree) {
    const held = new Map();
    this.list.replaceChildren();
    const order = new Map(tree.rays.map(ray => [ray.number, ray]));
    for (const ray of tree.rays) {
      const own = make("details", { open: ray.branch > 0.01 },
        make("summary", {}, make("b", {}, `${ray.percent} `), marked(tree.colours[ray.kind]), ray.heading),
        make("ul", {}, ...ray.lines.map(line => make("li", { className: line.colour ? "" : "dim" },
          line.colour ? `${line.percent} ${line.text}: ${line.colour}` : line.text))));
      own.dataset.ray = ray.number;
      own.addEventListener("pointerenter", () => this.choose(ray.number));
      own.addEventListener("focusin", event => { event.stopPropagation(); this.choose(ray.number); });
      held.set(ray.number, own);
    }
    for (const [number, own] of held) {
      const ray = order.get(number);
      // browsers cut what is nested deeper
      (ray.parent === null || ray.generation > 100 ? this.list : held.get(ray.parent)).append(own);
    }
  }

  choose(number) {
    this.chosen = number;
    this.draw();
  }

  draw() {
    const { tree, canvas } = this;
    if (!tree || !canvas.clientWidth) return;
    const ratio = devicePixelRatio || 1, wide = canvas.clientWidth, tall = canvas.clientHeight;
    canvas.width = wide * ratio;
    canvas.height = tall * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, wide, tall);
    const middle = scaled(add(tree.low, tree.high), 0.5), size = Math.hypot(...minus(tree.high, tree.low));
    const up = unit(this.up ?? [0, 1, 0]);
    const east = unit(cross(up, Math.abs(up[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0])), south = cross(east, up);
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const right = add(scaled(east, cy), scaled(south, -sy)), back = add(scaled(east, sy), scaled(south, cy));
    const above = add(scaled(up, cp), scaled(back, -sp)), scale = this.zoom * Math.min(wide, tall) / size;
    const at = point => {
      const p = minus(point, middle);
      return [wide / 2 + scale * dot(p, right), tall / 2 - scale * dot(p, above)];
    };
    const path = (points, close) => {
      pen.beginPath();
      points.forEach(([x, y], i) => i ? pen.lineTo(x, y) : pen.moveTo(x, y));
      if (close) pen.closePath();
    };
    pen.lineWidth = 1;
    for (const solid of tree.solids) {
      path(hull(solid.points.map(at)), true);
      pen.fillStyle = "rgb(127 143 160 / 10%)";
      pen.strokeStyle = "#7f8fa0";
      pen.fill();
      pen.stroke();
    }
    for (const thin of [true, false]) {
      for (const way of tree.ways) {
        const feeler = way.kind === "light" || way.kind === "blocked";
        if (feeler !== thin) continue;
        pen.setLineDash(feeler ? way.kind === "light" ? [4, 3] : [1, 3] : []);
        pen.strokeStyle = tree.colours[way.kind];
        pen.lineWidth = (feeler ? 0.7 : 0.9 + 2.6 * Math.sqrt(clamp(way.share, 0, 1)))
          + (way.ray === this.chosen ? 1.6 : 0);
        path([at(way.start), at(way.end)]);
        pen.stroke();
      }
    }
    pen.setLineDash([]);
  }

  close() {
    this.watch.disconnect();
  }
}
