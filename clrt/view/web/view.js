// --- all of it: a picture to turn, and panels beside it

const KEYS = [["arrows", "turn"], ["shift + arrows", "move sideways"], ["+ −", "nearer, farther"], ["0", "back to the start"],
  [", .", "darker, brighter"], ["p", "choose a pixel: arrows (with shift: ten), then enter"]];
const WIDTHS = [160, 240, 320, 480, 640, 960, 1280, 1920];

class View {
  constructor(root, connection, about) {
    Object.assign(this, { root, connection, about, layer: "image" });
    const [wide, tall] = about.size;
    this.aspect = wide / tall;
    this.width = Math.min(wide, matchMedia("(max-width: 40em)").matches ? 320 : 640);
    this.orbit = new Orbit(about.camera, about.mirror);
    this.screen = new Screen();
    this.rays = new Rays();
    this.rays.up = about.camera.up;
    this.pictures = new Pictures(connection, () => this.wish(), frame => this.shown(frame), fault => this.failed(fault));
    const most = about.adaptive ? Math.min(64, about.spp) : 64; // the scene's own picture is the last, and the best
    this.pictures.samples = [...new Set([1, 4, 16, about.spp])].filter(spp => spp <= most).sort((a, b) => a - b);
    this.knobs = new Knobs(about.knobs, () => this.changed());
    this.build();
    this.listen();
    this.pictures.next();
  }

  get height() {
    return Math.max(1, Math.round(this.width / this.aspect));
  }

  state() {
    return { camera: this.orbit.stated(), changes: this.knobs.changes };
  }

  wish() {
    return { ...this.state(), width: this.width, height: this.height, layer: this.layer };
  }

  changed() {
    this.mark(null);
    this.pictures.changed();
  }

  // --- what is there

  build() {
    const { canvas } = this.screen, { about } = this;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", `Picture of ${about.title}. Arrow keys turn it, p chooses a pixel.`);
    canvas.style.aspectRatio = `${about.size[0]} / ${about.size[1]}`;
    this.cross = make("div", { className: "cross", hidden: true });
    this.status = make("p", { className: "status", role: "status" });
    this.fault = make("p", { className: "fault", role: "alert", hidden: true });
    const width = { value: about.size[0], text: `${about.size[0]} (the scene's)` };
    const widths = [...WIDTHS.filter(w => w < about.size[0]).map(w => ({ value: w, text: w })), width];
    if (!widths.some(w => w.value === this.width)) widths.unshift({ value: this.width, text: this.width });
    this.exposure = slider("exposure in stops", 0, -8, 8, stops => this.expose(stops));
    const layers = [{ names: [{ value: "image", text: "the picture" }] }, ...about.layers];
    this.samples = select([{ names: [{ value: "1", text: "1 sample" }, { value: "shown", text: "those shown" }] }], "1",
      () => {});
    const panel = (name, open, ...children) => make("details", { open, className: "panel" }, make("summary", {}, name),
      ...children);
    const keys = make("dl", {}, ...KEYS.flatMap(([key, what]) => [make("dt", {}, key), make("dd", {}, what)]));
    const mouse = "Drag: turn. Shift or right button: move. Wheel: zoom. Click: a pixel's rays. "
      + "Fingers: one turns, two move and zoom.";
    const save = (text, what) => button(text, () => this.save(what));
    const stage = make("div", { className: "stage" }, canvas, this.cross);
    stage.style.maxWidth = `${85 * this.aspect}vh`;
    this.root.replaceChildren(
      make("header", {}, make("h1", {}, about.title), this.status),
      make("div", { className: "main" }, stage,
        panel("Pixel", true, labelled("samples", this.samples),
          this.hint = make("p", { className: "dim" }, "Click into the picture to see where a pixel's light comes from."),
          this.rays.root)),
      make("aside", {}, this.fault,
        panel("Picture", true,
          labelled("exposure", this.exposure.element),
          labelled("layer", this.layers = select(layers, "image", name => { this.layer = name; this.changed(); })),
          labelled("width", select([{ names: widths }], this.width, w => { this.width = Number(w); this.resized(); })),
          labelled("while moving", this.moving = select(
            [{ names: [{ value: "auto", text: "as fast as goes" }, "coarse", "full"] }],
            "auto", how => { this.pictures.moving = how; })),
          make("div", { className: "row" }, save("save PNG", "png"), save("save EXR", "exr"), save("save scene", "scene"),
            button("reset", () => this.reset()))),
        panel("Camera", false, ...this.lens()),
        panel("Materials and lights", false, ...this.knobs.groups),
        panel("Keys", false, make("p", {}, mouse), keys)));
    this.root.dataset.ready = "yes";
  }

  lens() {
    const { camera } = this.about, near = camera.focus;
    const of = (name, text, low, high, how) => {
      const control = slider(text, camera[name], low, high, v => { this.orbit.set(name, v); this.changed(); }, how);
      (this.lenses ??= []).push([name, control]);
      return labelled(text, control.element);
    };
    const angle = camera.type === "orthographic" ? of("size", "width of the view", camera.size / 10, camera.size * 10, { log: true })
      : of("fov", "field of view", 1, 170);
    return [angle, of("aperture", "aperture", 0, Math.max(near / 10, 2 * camera.aperture)),
      of("focus", "focus", near / 10, near * 10, { log: true })];
  }

  // --- what happens

  shown(frame) {
    this.screen.draw(frame);
    this.frame = frame;
    this.fault.hidden = true;
    const rate = frame.level < 2 ? `, ${(1000 / frame.took).toFixed(0)} pictures a second` : "";
    this.status.textContent = `${frame.width} × ${frame.height}, ${frame.spp} sample${frame.spp > 1 ? "s" : ""}${rate}`;
    Object.assign(this.root.dataset, { version: frame.version, level: frame.level, spp: frame.spp,
      frames: this.pictures.frames.join(" ") });
  }

  failed(fault) {
    if (!(fault instanceof Refused)) console.error(fault);
    this.fault.textContent = fault.message;
    this.fault.hidden = false;
  }

  async try(doing) {
    try {
      await doing();
    } catch (fault) {
      this.failed(fault);
    }
  }

  expose(stops) {
    this.screen.stops = stops;
    this.screen.draw();
  }

  resized() {
    this.mark(null);
    this.pictures.resized();
  }

  reset() {
    this.orbit.home();
    this.knobs.reset();
    for (const [name, control] of this.lenses) control.show(this.about.camera[name]);
    this.exposure.show(0);
    this.expose(0);
    this.layer = this.layers.value = "image";
    this.changed();
  }

  save(what) {
    const spp = this.frame && this.frame.level ? this.frame.spp : 1, exposure = this.screen.stops;
    return this.try(async () => download(...await this.connection.ask("save", { ...this.wish(), spp, exposure, what })));
  }

  pick(x, y) {
    x = clamp(Math.floor(x), 0, this.width - 1);
    y = clamp(Math.floor(y), 0, this.height - 1);
    const { width, height } = this, shown = this.frame && this.frame.level ? this.frame.spp : 1;
    const spp = this.samples.value === "shown" ? shown : 1;
    this.mark([x, y]);
    const number = this.picks = (this.picks ?? 0) + 1;
    this.hint.textContent = "…";
    this.hint.hidden = false;
    return this.try(async () => {
      try {
        const [tree] = await this.connection.ask("pixel", { ...this.state(), width, height, spp, x, y });
        if (number !== this.picks) return;
        this.rays.show(tree);
        this.root.dataset.picked = `${x} ${y}`;
      } finally {
        if (number === this.picks) this.hint.hidden = true;
      }
    });
  }

  // where the chosen pixel is; null: nowhere
  mark(place) {
    this.place = place;
    this.cross.hidden = !place;
    if (place) {
      this.cross.style.left = `${100 * (place[0] + 0.5) / this.width}%`;
      this.cross.style.top = `${100 * (place[1] + 0.5) / this.height}%`;
    }
  }

  turn(across, upwards) {
    this.orbit.turn(across, upwards);
    this.changed();
  }

  pan(across, upwards) {
    this.orbit.pan(across, upwards, this.aspect);
    this.changed();
  }

  zoom(factor) {
    this.orbit.zoom(factor);
    this.changed();
  }

  // --- mouse, fingers, keys

  listen() {
    const { canvas } = this.screen, fingers = new Map();
    const wide = () => canvas.getBoundingClientRect().width;
    let moved = 0;
    canvas.addEventListener("contextmenu", event => event.preventDefault());
    canvas.addEventListener("pointerdown", event => {
      canvas.setPointerCapture(event.pointerId);
      if (!fingers.size) moved = 0;
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", event => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const now = [event.clientX, event.clientY], step = minus(now, before);
      moved += Math.hypot(...step);
      fingers.set(event.pointerId, now);
      if (moved < 4) return;
      if (fingers.size === 2) {
        const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
        this.orbit.zoom(clamp(Math.hypot(...minus(before, other)) / (Math.hypot(...minus(now, other)) || 1), 0.2, 5));
        this.pan(step[0] / 2 / wide(), -step[1] / 2 / wide());
      } else if (event.shiftKey || event.buttons & 6) this.pan(step[0] / wide(), -step[1] / wide());
      else this.turn(step[0] / wide() * Math.PI, step[1] / wide() * Math.PI);
    });
    const up = event => {
      if (!fingers.delete(event.pointerId) || event.type !== "pointerup" || moved >= 4 || event.button) return;
      const box = canvas.getBoundingClientRect();
      this.pick((event.clientX - box.left) / box.width * this.width, (event.clientY - box.top) / box.height * this.height);
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      this.zoom(Math.exp(clamp(event.deltaY, -200, 200) / 700));
    }, { passive: false });
    canvas.addEventListener("keydown", event => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.key(event.key, event.shiftKey)) return;
      event.preventDefault();
    });
  }

  key(key, shift) {
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key];
    if (this.choosing && this.place) {
      if (key === "Escape" || key === "p") { this.choosing = false; this.mark(null); return true; }
      if (key === "Enter") { this.pick(...this.place); return true; }
      if (arrow) {
        const step = shift ? 10 : 1, [x, y] = this.place;
        this.mark([clamp(x + step * arrow[0], 0, this.width - 1), clamp(y - step * arrow[1], 0, this.height - 1)]);
        return true;
      }
    }
    if (arrow) shift ? this.pan(-arrow[0] / 20, -arrow[1] / 20) : this.turn(arrow[0] / 12, arrow[1] / 12);
    else if (key === "+" || key === "=") this.zoom(1 / 1.1);
    else if (key === "-" || key === "−") this.zoom(1.1);
    else if (key === "0" || key === "Home") { this.orbit.home(); this.changed(); }
    else if (key === "," || key === ".") {
      const stops = clamp(this.screen.stops + (key === "." ? 0.5 : -0.5), -8, 8);
      this.exposure.show(stops);
      this.expose(stops);
    } else if (key === "p") {
      this.choosing = true;
      this.mark(this.place ?? [this.width >> 1, this.height >> 1]);
    } else return false;
    return true;
  }

  close() {
    clearTimeout(this.pictures.timer);
    this.pictures.number = this.pictures.newest = Infinity; // what still comes is too late
    this.rays.close();
    this.connection.close?.();
  }
}

// what anywidget calls; `connection` in place of a notebook's
const render = ({ model, el, connection = new OverModel(model) }) => {
  const root = make("div", { className: "clrt-view" }, "…");
  // a notebook has shortcuts of its own: JupyterLab leaves out what is marked so, others hear nothing
  root.dataset.lmSuppressShortcuts = "true";
  root.addEventListener("keydown", event => event.stopPropagation());
  const frame = make("div", { className: "clrt-view-frame" }, root);
  el.append(frame);
  let view, closed = false;
  connection.ask("open", {}).then(([about]) => {
    if (closed) return;
    document.getElementById("clrt-view-page") === el && (document.title = `${about.title} - clrt view`);
    view = new View(root, connection, about);
    el.clrtView = view;
  }).catch(fault => {
    if (!(fault instanceof Refused)) console.error(fault);
    root.textContent = fault.message;
  });
  return () => {
    closed = true;
    view?.close();
    frame.remove();
  };
};

export default { render };

const page = document.getElementById("clrt-view-page");
if (page && location.hostname === "127.0.0.1") render({ el: page, connection: new OverHttp() });
