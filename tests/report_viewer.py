"""The report's viewer in a browser: where it is, what it shows, and what it should show."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

import report_samples as samples
from browser import Browser
from clrt.images.file import encode

WRONG = 2  # the case whose pictures differ
VIEWER = f"document.querySelector('#case-{WRONG} .viewer')"
CANVAS = f"{VIEWER}.querySelector('canvas')"


def look(browser: Browser, page: str, **how: Any) -> None:
    """Open the page at the case that differs, with its viewer ready and in sight."""
    browser.open(f"{page}#case-{WRONG}", **how)
    browser.wait(f"{VIEWER}.dataset.ready")
    browser.run(f"{CANVAS}.scrollIntoView({{block: 'center'}})")


def state(browser: Browser) -> dict[str, Any]:
    return json.loads(browser.run(f"JSON.stringify({VIEWER}.dataset)"))


def box(browser: Browser) -> tuple[float, float, float, float]:
    """Left, top, width, height of the canvas in the window."""
    found = browser.run(f"(b => [b.left, b.top, b.width, b.height])({CANVAS}.getBoundingClientRect())")
    return tuple(found)


def place(browser: Browser, x: float, y: float) -> tuple[float, float]:
    """Where the middle of a pixel of the unzoomed picture is in the window."""
    left, top, width, height = box(browser)
    return left + (x + 0.5) / 160 * width, top + (y + 0.5) / 120 * height


def drawn(browser: Browser, x: int, y: int) -> list[int]:
    """What the canvas shows in the middle of a pixel of the unzoomed picture."""
    left, top = f"({x} + 0.5) / 160 * {CANVAS}.width", f"({y} + 0.5) / 120 * {CANVAS}.height"
    reader = "new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true })"
    read = f"c.drawImage({CANVAS}, {left}, {top}, 1, 1, 0, 0, 1, 1), [...c.getImageData(0, 0, 1, 1).data]"
    return list(browser.run(f"(c => ({read}))({reader})"))[:3]


def bytes_of() -> tuple[np.ndarray, np.ndarray]:
    case = samples.result().cases[WRONG]
    return encode(case.ours.pixels), encode(case.results["oracle64"][0].pixels.astype(np.float32))


def differing() -> tuple[int, int]:
    """x, y of the pixel where the pictures differ most."""
    ours, reference = bytes_of()
    y, x = np.unravel_index(np.abs(ours.astype(int) - reference).sum(axis=-1).argmax(), ours.shape[:2])
    return int(x), int(y)


# texts whose colour has a contrast below 4.5 with what is behind them (WCAG 2, level AA)
CONTRAST = """(() => {
  const parse = text => text.match(/[\\d.]+/g).map(Number);
  const linear = v => v <= 10.31475 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b) + 0.05;
  const behind = element => {
    const color = parse(getComputedStyle(element).backgroundColor);
    return color.length < 4 || color[3] === 1 ? color : behind(element.parentElement);
  };
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), bad = [];
  let seen = 0;
  while (walk.nextNode()) {
    const element = walk.currentNode.parentElement, text = walk.currentNode.data.trim();
    if (!text || !element.checkVisibility() || /SCRIPT|STYLE/.test(element.tagName)) continue;
    const a = light(parse(getComputedStyle(element).color)), b = light(behind(element));
    if (Math.max(a, b) / Math.min(a, b) < 4.5) bad.push(text);
    seen++;
  }
  return [bad.join("; "), seen];
})()"""
