"use strict";
// Looks into the pictures of one case: slider, flicker, maps, zoom, values; by mouse, keyboard and finger.

const VIEWS = [["slider", "slider"], ["flicker", "flicker"], ["ours", "ours"], ["reference", "reference"],
               ["difference", "difference"], ["flip", "FLIP"], ["ssim", "SSIM"]];
const KEYS = [["←↑→↓", "choose a pixel (with shift: ten)"], ["+ − 0", "zoom in, out, fit"], [", .", "move the slider"],
              ["1 2 3 …", "change the view"], ["space", "swap in flicker"], ["e", "show edges"],
              ["wheel", "zoom"], ["drag", "move picture or slider"]];
const FLICKER_MS = 600; // below three changes a second
const MOST_ZOOM = 64;
const STILL = matchMedia("(prefers-reduced-motion: reduce)");

// --- the viewer of a case: what is shown is a function of its state, drawn by `draw`

class Viewer {
  constructor(root, data, name) {
    Object.assign(this, { root, data, view: "slider", split: 0.5, zoom: 1, left: 0, top: 0, phase: 0, edges: false });
    const measured = Object.values(data.oracles).every(stored => stored.flip); // FLIP's package may be missing
    this.views = VIEWS.filter(([view]) => view !== "flip" || measured);
    this.cursor = { x: data.width >> 1, y: data.height >> 1 };
    this.fingers = new Map();
    this.loaded = new Map();
    this.canvas = make("canvas", { tabIndex: 0, role: "application",
      "aria-label": `${name}: our picture and an oracle's. Arrow keys choose a pixel, whose values are told below.` });
    this.canvas.style.aspectRatio = `${data.width} / ${data.height}`;
    this.slider = make("input", { type: "range", className: "split", min: 0, max: 1, step: "any", value: 0.5,
      "aria-label": "Slider: how much of the width is ours" });
    this.values = make("div", { className: "values" });
    this.legend = make("div", { className: "legend" });
    this.build(name);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.timer = setInterval(() => this.flick(), FLICKER_MS);
    this.choose(Object.keys(data.oracles)[0]);
  }

  build(name) {
    const group = `view of ${name}`;
    this.radios = this.views.map(([view, label]) => {
      const radio = make("input", { type: "radio", name: group, value: view, checked: view === this.view });
      radio.addEventListener("change", () => this.show(view));
      return make("label", {}, radio, label);
    });
    this.oracle = make("select", {}, ...Object.keys(this.data.oracles).map(name => make("option", {}, name)));
    this.oracle.addEventListener("change", () => this.choose(this.oracle.value));
    this.edge = make("input", { type: "checkbox" });
    this.edge.addEventListener("change", () => this.set({ edges: this.edge.checked }));
    const button = (text, label, act) => {
      const element = make("button", { type: "button", "aria-label": label }, text);
      element.addEventListener("click", act);
      return element;
    };
    this.root.append(
      make("div", { className: "bar" },
        make("fieldset", {}, make("legend", {}, "Show"), ...this.radios),
        make("label", {}, "against ", this.oracle),
        make("label", {}, this.edge, " edges"),
        make("span", {}, button("−", "Zoom out", () => this.magnify(0.5)), " ",
          button("+", "Zoom in", () => this.magnify(2)), " ", button("Fit", "Show all", () => this.magnify(0)))),
      make("div", {}, this.canvas, this.slider),
      make("div", {}, this.values, this.legend, make("div", { className: "quiet keys" }, make("p", {}, "With the picture selected:"),
        make("ul", {}, ...KEYS.map(([keys, what]) => make("li", {}, make("kbd", {}, keys), ` ${what}`))))));
  }

  listen() {
    const canvas = this.canvas;
    this.slider.addEventListener("input", () => this.set({ split: Number(this.slider.value) }));
    canvas.addEventListener("pointerdown", event => {
      this.fingers.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
      this.grip = this.view === "slider" && (this.zoom === 1 || Math.abs(event.offsetX - this.split * canvas.clientWidth) < 16);
      this.point(event);
    });
    canvas.addEventListener("pointermove", event => this.move(event));
    for (const type of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(type, event => this.fingers.delete(event.pointerId));
    }
    canvas.addEventListener("dblclick", event => this.magnify(2, event));
    canvas.addEventListener("wheel", event => {
      if (document.activeElement !== canvas && !event.ctrlKey) return; // else the page could not be scrolled
      event.preventDefault();
      this.magnify(2 ** (-event.deltaY / 250), event);
    }, { passive: false });
    canvas.addEventListener("keydown", event => this.key(event));
  }

  async choose(oracle) {
    if (!this.ours) this.ours = await pixels(this.data.ours);
    if (!this.loaded.has(oracle)) this.loaded.set(oracle, await load(this.ours, this.data.oracles[oracle]));
    this.now = this.loaded.get(oracle);
    this.set({});
    this.root.dataset.ready = oracle;
  }

  show(view) {
    this.root.querySelector(`input[value="${view}"]`).checked = true;
    this.set({ view, phase: 0 });
    this.legend.replaceChildren(...legend(view));
  }

  set(changes) {
    Object.assign(this, changes);
    const { width, height } = this.data;
    this.zoom = Math.min(Math.max(this.zoom, 1), MOST_ZOOM);
    this.left = Math.min(Math.max(this.left, 0), width - width / this.zoom);
    this.top = Math.min(Math.max(this.top, 0), height - height / this.zoom);
    this.split = Math.min(Math.max(this.split, 0), 1);
    this.slider.value = this.split;
    this.slider.hidden = this.view !== "slider";
    this.edge.checked = this.edges;
    this.root.classList.toggle("zoomed", this.zoom > 1);
    Object.assign(this.root.dataset, { view: this.view, zoom: this.zoom, split: this.split });
    this.draw();
    this.tell();
  }

  flick() {
    if (this.view !== "flicker" || this.root.offsetParent === null || STILL.matches) return;
    this.set({ phase: 1 - this.phase });
  }

  // --- where a pointer is, in pixels of the picture

  at(event) {
    const scale = this.data.width / this.zoom / this.canvas.clientWidth;
    return { x: this.left + event.offsetX * scale, y: this.top + event.offsetY * scale };
  }

  point(event) {
    const { x, y } = this.at(event), { width, height } = this.data;
    this.cursor = { x: Math.min(Math.max(Math.floor(x), 0), width - 1), y: Math.min(Math.max(Math.floor(y), 0), height - 1) };
    this.values.setAttribute("aria-live", "off");
    this.set({});
  }

  move(event) {
    const last = this.fingers.get(event.pointerId);
    if (last && this.fingers.size === 2) this.pinch(event);
    else if (last && this.grip) this.split = event.offsetX / this.canvas.clientWidth;
    else if (last) {
      const before = this.at(last), now = this.at(event);
      this.left -= now.x - before.x;
      this.top -= now.y - before.y;
    }
    if (last) this.fingers.set(event.pointerId, event);
    this.point(event);
  }

  pinch(event) {
    const distance = () => {
      const [a, b] = [...this.fingers.values()];
      return Math.hypot(a.offsetX - b.offsetX, a.offsetY - b.offsetY);
    };
    const before = distance();
    this.fingers.set(event.pointerId, event);
    if (before > 0) this.magnify(distance() / before, event);
  }

  // what is under the pointer, or the chosen pixel, stays where it is
  magnify(factor, event) {
    if (!factor) return this.set({ zoom: 1, left: 0, top: 0 });
    const { x, y } = event ? this.at(event) : { x: this.cursor.x + 0.5, y: this.cursor.y + 0.5 };
    const zoom = Math.min(Math.max(this.zoom * factor, 1), MOST_ZOOM), ratio = this.zoom / zoom;
    this.set({ zoom, left: x - (x - this.left) * ratio, top: y - (y - this.top) * ratio });
    if (!event) this.reveal();
  }

  // moves the picture so that the chosen pixel is in sight
  reveal() {
    const { width, height } = this.data, { x, y } = this.cursor, w = width / this.zoom, h = height / this.zoom;
    if (x < this.left || x + 1 > this.left + w) this.left = x + 0.5 - w / 2;
    if (y < this.top || y + 1 > this.top + h) this.top = y + 0.5 - h / 2;
    this.set({});
  }

  key(event) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const acts = {
      "+": () => this.magnify(2), "=": () => this.magnify(2), "-": () => this.magnify(0.5), 0: () => this.magnify(0),
      ",": () => this.set({ split: this.split - 0.02 }), ".": () => this.set({ split: this.split + 0.02 }),
      e: () => this.set({ edges: !this.edges }), " ": () => this.set({ phase: 1 - this.phase }),
    };
    this.views.forEach(([view], i) => { acts[i + 1] = () => this.show(view); });
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (steps[event.key]) {
      const [dx, dy] = steps[event.key], far = event.shiftKey ? 10 : 1, { width, height } = this.data;
      this.cursor = { x: Math.min(Math.max(this.cursor.x + dx * far, 0), width - 1),
                      y: Math.min(Math.max(this.cursor.y + dy * far, 0), height - 1) };
      this.values.setAttribute("aria-live", "polite");
      this.reveal();
    } else if (acts[event.key]) acts[event.key]();
    else return;
    event.preventDefault();
  }

  // --- drawing

  draw() {
    if (!this.now || !this.canvas.clientWidth) return;
    const { width, height } = this.data, canvas = this.canvas, context = canvas.getContext("2d"), ratio = devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.width * height / width);
    const k = canvas.width / width * this.zoom; // device pixels of a pixel
    context.imageSmoothingEnabled = false;
    const put = picture => {
      context.setTransform(k, 0, 0, k, -this.left * k, -this.top * k);
      context.drawImage(picture, 0, 0);
      context.setTransform(1, 0, 0, 1, 0, 0);
    };
    const { layers } = this.now, single = { flicker: ["ours", "reference"][this.phase] }[this.view] || this.view;
    put(layers[single === "slider" ? "reference" : single]);
    if (this.view === "slider") {
      const x = this.split * canvas.width;
      context.save();
      context.beginPath();
      context.rect(0, 0, x, canvas.height);
      context.clip();
      put(layers.ours);
      context.restore();
      context.fillStyle = "#fff";
      context.fillRect(x - ratio, 0, 2 * ratio, canvas.height);
      this.label("ours", 0, ratio);
      this.label(this.oracle.value, 1, ratio);
    } else if (["flicker", "ours", "reference"].includes(this.view)) {
      this.label(single === "ours" ? "ours" : this.oracle.value, 0, ratio);
    }
    if (this.edges) put(layers.edges);
    const frame = (this.cursor.x - this.left) * k, line = (this.cursor.y - this.top) * k;
    context.lineWidth = 3 * ratio;
    for (const color of ["#000", "#fff"]) {
      context.strokeStyle = color;
      context.strokeRect(frame - ratio, line - ratio, k + 2 * ratio, k + 2 * ratio);
      context.lineWidth = ratio;
    }
    if (k / ratio >= 44) this.numbers(k, ratio, single);
  }

  label(text, side, ratio) {
    const context = this.canvas.getContext("2d"), size = 13 * ratio;
    context.font = `${size}px system-ui, sans-serif`;
    const width = context.measureText(text).width + size, x = side ? this.canvas.width - width : 0;
    context.fillStyle = "rgba(0, 0, 0, 0.72)";
    context.fillRect(x, 0, width, 1.7 * size);
    context.fillStyle = "#fff";
    context.fillText(text, x + size / 2, 1.2 * size);
  }

  // each pixel's values, written into it
  numbers(k, ratio, view) {
    const { width, height } = this.data, context = this.canvas.getContext("2d"), size = Math.min(k / 6, 14 * ratio);
    context.font = `${size}px ui-monospace, monospace`;
    for (let y = Math.floor(this.top); y < Math.min(this.top + height / this.zoom, height); y++) {
      for (let x = Math.floor(this.left); x < Math.min(this.left + width / this.zoom, width); x++) {
        const ours = view === "slider" && (x + 0.5 - this.left) * k < this.split * this.canvas.width;
        this.read(x, y, view === "slider" ? (ours ? "ours" : "reference") : view).forEach((text, i) => {
          const place = [(x - this.left) * k + size / 3, (y - this.top) * k + (i + 1.3) * size];
          context.strokeStyle = "#000";
          context.lineWidth = size / 4;
          context.strokeText(text, ...place);
          context.fillStyle = "#fff";
          context.fillText(text, ...place);
        });
      }
    }
  }

  // a pixel's values in a view, as texts
  read(x, y, view) {
    const i = 4 * (y * this.data.width + x), { maps } = this.now;
    if (view === "flip") return [rooted(maps.flip.data[i]).toPrecision(2)];
    if (view === "ssim") return [(1 - rooted(maps.ssim.data[i])).toFixed(4)];
    if (view === "difference") return [0, 1, 2].map(c => signed(maps.difference.data[i + c]));
    const bytes = (view === "reference" ? maps.reference : this.ours).data;
    return [0, 1, 2].map(c => bytes[i + c] === 255 ? "≥ 1" : linear(bytes[i + c]).toFixed(3));
  }

  tell() {
    if (!this.now) return;
    const { x, y } = this.cursor, i = 4 * (y * this.data.width + x);
    const line = (name, view) => name.padEnd(7) + this.read(x, y, view).map(text => text.padStart(9)).join("");
    this.values.textContent = [
      `pixel (${x}, ${y})${this.now.maps.mask.data[i] ? ", on an edge" : ""}`,
      line("ours", "ours"), line("oracle", "reference"), line("apart", "difference"),
      `${this.now.maps.flip ? `FLIP ${this.read(x, y, "flip")}   ` : ""}SSIM ${this.read(x, y, "ssim")}`,
    ].join("\n");
  }
}
