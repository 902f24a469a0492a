// --- pictures: float16 light on a canvas, and who asks for it

// what a screen shows of each float16: sRGB, 8 bits, as clrt's own picture files
const shades = stops => {
  const table = new Uint8Array(65536), gain = 2 ** stops;
  for (let bits = 1; bits < 0x8000; bits++) {
    const exponent = bits >> 10, part = bits & 1023;
    const value = exponent ? (1 + part / 1024) * 2 ** (exponent - 15) : part * 2 ** -24;
    const light = exponent === 31 ? 1 : Math.min(value * gain, 1);
    table[bits] = Math.floor(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055) + 0.5);
  }
  return table;
};

class Screen {
  constructor() {
    this.canvas = make("canvas", { tabIndex: 0, width: 1, height: 1 });
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.tables = new Map();
    this.stops = 0;
  }

  draw(frame = this.frame) {
    if (!frame) return;
    this.frame = frame;
    const { width, height, light, values } = frame, stops = light ? this.stops : 0;
    if (!this.tables.has(stops)) {
      if (this.tables.size > 8) this.tables.clear();
      this.tables.set(stops, shades(stops));
    }
    const table = this.tables.get(stops);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const image = this.context.createImageData(width, height), bytes = image.data;
    for (let from = 0, to = 0; from < values.length; from += 3, to += 4) {
      bytes[to] = table[values[from]];
      bytes[to + 1] = table[values[from + 1]];
      bytes[to + 2] = table[values[from + 2]];
      bytes[to + 3] = 255;
    }
    this.context.putImageData(image, 0, 0);
  }
}

const COARSE = 4; // pixels of the full picture across one of the coarse one
const FAST = 100; // ms within which a full picture has to come while things move
const STILL = 150; // ms without a change after which the picture is made better
const SLOW = 1000; // ms after which even a first picture of what was before is given up

// Asks for pictures of the newest wish: coarse, full, then of more samples. One question is under way, but for
// one that takes long and shows what is no more: the server gives that up when it hears the next.
class Pictures {
  constructor(connection, wish, shown, failed) {
    Object.assign(this, { connection, wish, shown, failed, version: 1, issued: 0, level: -1, number: 0,
      newest: 0 });
    this.page = crypto.getRandomValues(new Uint32Array(4)).join("-");
    this.moving = "auto";
    this.took = new Map(); // by level, ms
    this.changedAt = -Infinity;
    this.samples = [1, 4, 16];
    this.frames = [0, 0];
  }

  levels(width, height) {
    const small = v => Math.max(1, Math.round(v / COARSE));
    return [{ width: small(width), height: small(height), spp: 1 },
      ...this.samples.map(spp => ({ width, height, spp }))];
  }

  changed() {
    this.version++;
    this.changedAt = performance.now();
    const busy = this.busy;
    if (!busy || busy.level > 1 || this.changedAt - busy.since > SLOW) this.next();
  }

  resized() {
    this.took.clear();
    this.changed();
  }

  quick() {
    if (this.moving !== "auto") return this.moving === "full" ? 1 : 0;
    return (this.took.get(1) ?? Infinity) < FAST ? 1 : 0;
  }

  async next() {
    clearTimeout(this.timer);
    const fresh = this.issued !== this.version, level = fresh ? this.quick() : this.level + 1;
    const wish = this.wish(), levels = this.levels(wish.width, wish.height);
    if (level >= levels.length) return;
    const rest = STILL - (performance.now() - this.changedAt);
    if (!fresh && rest > 0) {
      this.timer = setTimeout(() => this.next(), rest);
      return;
    }
    const mine = { level, version: this.version, since: performance.now(), number: ++this.number };
    this.busy = mine;
    this.issued = this.version;
    this.level = level;
    const { page } = this, { number } = mine;
    try {
      const [table, bytes] = await this.connection.ask("frame", { ...wish, ...levels[level], page, number });
      if (table.superseded || number < this.newest) return;
      this.newest = number;
      const took = performance.now() - mine.since;
      this.took.set(level, this.took.has(level) ? 0.7 * this.took.get(level) + 0.3 * took : took);
      this.frames[level ? 1 : 0]++;
      this.shown({ ...table, ...mine, spp: levels[level].spp, took, values: new Uint16Array(bytes) });
    } catch (fault) {
      if (this.number !== number) return;
      this.level = levels.length; // until something changes
      this.failed(fault, wish);
    }
    if (this.number !== number) return; // another question is under way
    this.busy = null;
    this.next();
  }
}
