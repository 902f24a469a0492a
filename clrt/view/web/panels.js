// --- sliders for what can be changed

const hex = color => `#${color.map(v => {
  const c = clamp(v, 0, 1), s = c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055;
  return Math.round(255 * s).toString(16).padStart(2, "0");
}).join("")}`;

const linear = text => [1, 3, 5].map(i => {
  const v = parseInt(text.slice(i, i + 2), 16) / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
});

// a slider and the number itself, of one value; `act` is told each new one
const slider = (name, value, low, high, act, { log = false, whole = false } = {}) => {
  const [to, from] = log ? [Math.log, Math.exp] : [v => v, v => v];
  const range = make("input", { type: "range", min: to(low), max: to(high), step: whole ? 1 : "any",
    "aria-label": name });
  const number = make("input", { type: "number", step: whole ? 1 : "any", "aria-label": `${name}, as a number` });
  const show = (v, both = true) => {
    range.value = to(v);
    if (both) number.value = Number(v.toPrecision(4));
  };
  show(value);
  range.addEventListener("input", () => {
    const v = whole ? Math.round(range.value) : Number(from(Number(range.value)).toPrecision(6));
    number.value = Number(v.toPrecision(4));
    act(v);
  });
  number.addEventListener("input", () => {
    if (number.value === "" || !Number.isFinite(number.valueAsNumber)) return;
    show(number.valueAsNumber, false);
    act(whole ? Math.round(number.valueAsNumber) : number.valueAsNumber);
  });
  return { element: make("span", { className: "slider" }, range, number), show };
};

const colour = (name, value, act) => {
  const input = make("input", { type: "color", value: hex(value), "aria-label": name });
  input.addEventListener("input", () => act(linear(input.value)));
  return { element: input, show: v => { input.value = hex(v); } };
};

// light may be brighter than a screen's white: how bright, and what colour
const lamp = (name, value, high, act) => {
  const most = v => Math.max(...v), tint = v => most(v) > 0 ? v.map(c => c / most(v)) : [1, 1, 1];
  let [power, colours] = [most(value), tint(value)];
  const tell = () => act(colours.map(c => c * power));
  const strength = slider(`${name}, how bright`, power, 0, high, v => { power = v; tell(); });
  const hue = colour(`${name}, its colour`, colours, v => { colours = v; tell(); });
  return {
    element: make("span", { className: "lamp" }, strength.element, hue.element),
    show: v => { [power, colours] = [most(v), tint(v)]; strength.show(power); hue.show(colours); },
  };
};

class Knobs {
  constructor(knobs, changed) {
    this.changes = {};
    this.shown = [];
    const groups = new Map();
    for (const knob of knobs) {
      if (!groups.has(knob.group)) groups.set(knob.group, make("details", {}, make("summary", {}, knob.group)));
      const act = value => { this.changes[knob.place] = value; changed(); };
      const name = `${knob.group}: ${knob.label}`;
      const options = { log: knob.kind === "log", whole: knob.kind === "whole" };
      const control = knob.kind === "color" ? colour(name, knob.value, act)
        : knob.kind === "light" ? lamp(name, knob.value, knob.high, act)
        : slider(name, knob.value, knob.low, knob.high, act, options);
      const row = make("div", { className: "knob" }, make("span", {}, knob.label), control.element);
      row.dataset.place = knob.place;
      groups.get(knob.group).append(row);
      this.shown.push([control, knob.value]);
    }
    this.groups = [...groups.values()];
  }

  reset() {
    this.changes = {};
    for (const [control, value] of this.shown) control.show(value);
  }
}
