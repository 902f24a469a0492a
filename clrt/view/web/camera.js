// --- a camera that turns about its target

const add = (a, b) => a.map((v, i) => v + b[i]);
const scaled = (a, s) => a.map(v => v * s);
const minus = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => scaled(a, 1 / Math.hypot(...a));
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
const POLE = 0.02; // radians that the view keeps from `up`, which has no right or left

class Orbit {
  constructor(camera, mirror) {
    this.first = camera;
    this.side = mirror ? -1 : 1;
    this.home();
  }

  home() {
    Object.assign(this, structuredClone(this.first));
    this.edited = new Set();
  }

  // about `up`, and towards it; radians
  turn(across, upwards) {
    const up = unit(this.up), away = minus(this.origin, this.target), far = Math.hypot(...away);
    const height = clamp(dot(away, up) / far, -1, 1);
    let level = minus(away, scaled(up, height * far));
    if (Math.hypot(...level) < 1e-6 * far) level = cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
    level = unit(level);
    const side = cross(up, level), a = -across * this.side;
    level = add(scaled(level, Math.cos(a)), scaled(side, Math.sin(a)));
    const tilt = clamp(Math.acos(height) - upwards, POLE, Math.PI - POLE);
    this.origin = add(this.target, scaled(add(scaled(up, Math.cos(tilt)), scaled(level, Math.sin(tilt))), far));
  }

  // by parts of the picture's width
  pan(across, upwards, aspect) {
    const gaze = minus(this.target, this.origin), far = Math.hypot(...gaze);
    const right = unit(cross(gaze, this.up)), up = unit(cross(right, gaze));
    let wide = this.type === "orthographic" ? this.size : 2 * far * Math.tan(this.fov * Math.PI / 360);
    if (this.fov_axis === "vertical") wide *= aspect;
    const step = add(scaled(right, -across * this.side * wide), scaled(up, -upwards * wide));
    this.origin = add(this.origin, step);
    this.target = add(this.target, step);
  }

  zoom(factor) {
    if (this.type === "orthographic") this.set("size", this.size * factor);
    else this.origin = add(this.target, scaled(minus(this.origin, this.target), factor));
  }

  set(name, value) {
    this[name] = value;
    this.edited.add(name);
  }

  stated() {
    const { origin, target, up } = this;
    const edited = [...this.edited].map(name => [name, this[name]]);
    return { origin, target, up, ...Object.fromEntries(edited) };
  }
}
