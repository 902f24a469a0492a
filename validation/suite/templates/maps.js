"use strict";
// Pictures and maps of a case: their bytes, the values that these stand for, their colours.

const SCALE = JSON.parse(document.getElementById("scale").textContent); // of differences: report_pictures.py

// --- values that a byte of a map stands for

function difference(byte) {
  const level = Math.abs(byte - 128);
  return level ? Math.sign(byte - 128) * SCALE.floor * 10 ** (SCALE.decades * (level - 1) / 126) : 0;
}
const rooted = byte => (byte / 255) ** 2;
const linear = byte => byte <= 10.31475 ? byte / 255 / 12.92 : ((byte / 255 + 0.055) / 1.055) ** 2.4;

function signed(byte) {
  const value = difference(byte);
  return value ? (value > 0 ? "+" : "−") + Math.abs(value).toExponential(1) : `<${SCALE.floor.toExponential(0)}`;
}

// --- colours of a map

const MAGMA = [[0, 0, 4], [40, 17, 89], [101, 26, 128], [160, 48, 126], [215, 69, 107], [249, 121, 93],
               [254, 187, 129], [252, 253, 191]];

function between(a, b, share) {
  return a.map((value, i) => value + (b[i] - value) * share);
}

function magma(byte) {
  const place = byte / 255 * (MAGMA.length - 1), i = Math.min(Math.floor(place), MAGMA.length - 2);
  return between(MAGMA[i], MAGMA[i + 1], place - i);
}

function diverging(byte) {
  const level = Math.abs(byte - 128) / 127;
  return level ? between([44, 46, 52], byte > 128 ? [255, 176, 64] : [92, 168, 255], 0.25 + 0.75 * level) : [44, 46, 52];
}

// the channel that differs most, so that no difference hides
function farthest(rgb, i) {
  let byte = rgb[i];
  for (const other of [rgb[i + 1], rgb[i + 2]]) if (Math.abs(other - 128) > Math.abs(byte - 128)) byte = other;
  return byte;
}

// --- pictures

async function pixels(base64) {
  const image = new Image();
  image.src = `data:image/png;base64,${base64}`;
  await image.decode();
  const canvas = new OffscreenCanvas(image.width, image.height);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height);
}

function layer(data, color) {
  const out = new ImageData(data.width, data.height);
  for (let i = 0; i < out.data.length; i += 4) out.data.set(color(data.data, i), i);
  const canvas = new OffscreenCanvas(data.width, data.height);
  canvas.getContext("2d").putImageData(out, 0, 0);
  return canvas;
}

async function load(ours, stored) {
  const names = Object.keys(stored), read = await Promise.all(names.map(name => pixels(stored[name])));
  const maps = Object.fromEntries(names.map((name, i) => [name, read[i]]));
  const reference = maps.reference.data; // stored as the exclusive or with ours
  for (let i = 0; i < reference.length; i++) if (i % 4 < 3) reference[i] ^= ours.data[i];
  const plain = (rgb, i) => [rgb[i], rgb[i + 1], rgb[i + 2], 255];
  const layers = {
    ours: layer(ours, plain),
    reference: layer(maps.reference, plain),
    difference: layer(maps.difference, (rgb, i) => [...diverging(farthest(rgb, i)), 255]),
    ssim: layer(maps.ssim, (rgb, i) => [...magma(rgb[i]), 255]),
    edges: layer(maps.mask, (rgb, i) => [80, 220, 120, rgb[i] ? 110 : 0]),
  };
  if (maps.flip) layers.flip = layer(maps.flip, (rgb, i) => [...magma(rgb[i]), 255]);
  return { maps, layers };
}

// --- elements

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element && name !== "role") element[name] = value; else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

// what the colours of a map mean: a bar and its ticks; nothing for a picture
function legend(view) {
  const [color, ticks] = {
    difference: [diverging, ["−3 ours darker", "−0.006", "equal", "0.006", "ours brighter 3"]],
    flip: [magma, ["0 equal", "0.06", "0.25", "0.56", "1"]],
    ssim: [magma, ["1 equal", "0.94", "0.75", "0.44", "0"]],
  }[view] || [];
  if (!color) return [];
  const canvas = make("canvas", { width: 256, height: 1 }), context = canvas.getContext("2d");
  for (let byte = 0; byte < 256; byte++) {
    context.fillStyle = `rgb(${color(byte).map(Math.round).join(",")})`;
    context.fillRect(byte, 0, 1, 1);
  }
  return [canvas, ...ticks.map(text => make("span", {}, text))];
}
