"""The page in a real browser: by mouse, keys and finger; nothing that a scene says is run."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import clrt
from browser import Browser
from clrt.images.file import encode
from clrt.view.server import Server
from clrt.view.session import Session
from report_viewer import CONTRAST
from tests.view_samples import EVIL, SIZE, scene, serving

pytestmark = pytest.mark.browser
WIDTH, HEIGHT = SIZE
PAGE = "document.querySelector('#clrt-view-page').clrtView"
ROOT = "document.querySelector('.clrt-view')"
# what the canvas shows
SHOWN = f"""(c => {{
  const reader = new OffscreenCanvas(c.width, c.height).getContext("2d", {{ willReadFrequently: true }});
  reader.drawImage(c, 0, 0);
  return [...reader.getImageData(0, 0, c.width, c.height).data];
}})({PAGE}.screen.canvas)"""
# the sum of a tree's rays in the film's order: queue by queue, in float32
FILM = f"""(tree => {{
  const film = [0, 0, 0], sums = new Map();
  for (const ray of tree.rays) {{
    const key = `${{ray.generation}} ${{ray.queue}}`;
    if (!sums.has(key)) sums.set(key, [0, 0, 0]);
    (ray.brings ?? [0, 0, 0]).forEach((v, i) => {{ sums.get(key)[i] = Math.fround(sums.get(key)[i] + v); }});
  }}
  for (const sum of sums.values()) sum.forEach((v, i) => {{ film[i] = Math.fround(film[i] + v); }});
  return [film.map(v => Math.fround(v / tree.samples)), tree.value];
}})({PAGE}.rays.tree)"""


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with serving(Session(clrt.Tracer(scene()))) as found:
        yield found


@pytest.fixture
def browser(chromium: Browser, server: Server) -> Iterator[Browser]:
    """Whatever a test does, the console stays empty, nothing of the scene runs, and nobody else is asked."""
    yield chromium
    assert chromium.messages == []
    assert chromium.run("window.evil === undefined")
    assert {
        url for url in chromium.requests if not url.startswith((server.address, "data:", "blob:"))
    } == set()


def look(browser: Browser, server: Server, **how: Any) -> None:
    browser.open(server.address, **how)
    settled(browser)


def settled(browser: Browser) -> None:
    """Until the picture of what is wished is there with all its samples."""
    browser.wait(f"(v => v && v.frame && !v.pictures.busy && v.frame.version === v.pictures.version && "
                 f"v.frame.spp === 16)({PAGE})", 60)  # fmt: skip


def center(browser: Browser) -> tuple[float, float]:
    left, top, wide, tall = browser.run(
        f"(b => [b.left, b.top, b.width, b.height])({PAGE}.screen.canvas.getBoundingClientRect())"
    )
    return left + wide / 2, top + tall / 2


def shown(browser: Browser) -> np.ndarray:
    return np.array(browser.run(SHOWN), np.uint8).reshape(-1, 4)[:, :3]


def test_the_picture_is_that_of_a_file(browser: Browser, server: Server) -> None:
    look(browser, server)
    right = encode(clrt.Tracer(scene()).render(spp=16).pixels).reshape(-1, 3)
    assert np.abs(shown(browser).astype(int) - right).max() <= 1
    assert browser.run("document.title") == f"{EVIL}.toml - clrt view"
    number = f"{PAGE}.exposure.element.querySelector('input[type=number]')"
    browser.run(f"{number}.value = 1; {number}.dispatchEvent(new Event('input'))")
    brighter = encode(clrt.Tracer(scene()).render(spp=16).pixels, 1.0).reshape(-1, 3)
    assert np.abs(shown(browser).astype(int) - brighter).max() <= 1


def test_it_is_coarse_first_then_full_then_of_more_samples(browser: Browser, server: Server) -> None:
    look(browser, server)
    browser.run(f"""(v => {{
      const show = v.shown.bind(v);
      window.seen = [];
      v.pictures.shown = frame => {{ seen.push([frame.level, frame.width, frame.spp]); show(frame); }};
      v.pictures.moving = "coarse";
      v.turn(0.1, 0);
    }})({PAGE})""")
    settled(browser)
    assert browser.run("JSON.stringify(seen)") == "[[0,8,1],[1,32,1],[2,32,4],[3,32,16]]"


def test_the_last_picture_of_an_adaptive_scene_is_its_own(chromium: Browser) -> None:
    own = scene().replace({"camera.spp": 9, "adaptive": {"spp": 36}})
    with serving(Session(clrt.Tracer(own))) as server:
        chromium.open(server.address)
        chromium.wait(f"(v => v && v.frame && !v.pictures.busy && v.frame.spp === 9)({PAGE})", 60)
        right = encode(clrt.Tracer(own).render().pixels).reshape(-1, 3)
        assert np.abs(shown(chromium).astype(int) - right).max() <= 1
        assert chromium.run(f"{PAGE}.pictures.samples") == [1, 4, 9]
        assert chromium.run(f"{PAGE}.fault.hidden") and chromium.messages == []


def test_pictures_are_full_while_things_move_where_they_come_fast(browser: Browser, server: Server) -> None:
    """Within a tenth of a second; else coarse. The user may want one or the other."""
    look(browser, server)
    quick = f"(p => {{ p.moving = HOW; p.took.set(1, MS); return p.quick(); }})({PAGE}.pictures)"
    for how, took, level in (("auto", 90, 1), ("auto", 110, 0), ("full", 900, 1), ("coarse", 1, 0)):
        assert browser.run(quick.replace("HOW", f"'{how}'").replace("MS", str(took))) == level


def test_it_turns_moves_and_zooms(browser: Browser, server: Server) -> None:
    look(browser, server)
    x, y = center(browser)
    first, state = shown(browser), f"JSON.stringify({PAGE}.orbit.stated())"

    def drag(**held: Any) -> None:
        for kind, dx in (("mousePressed", 0), ("mouseMoved", 30), ("mouseMoved", 60), ("mouseReleased", 60)):
            browser.mouse(kind, x + dx, y, clickCount=1, **{"button": "left", "buttons": 1, **held})

    acts = {
        "drag": drag,
        "shift": lambda: drag(modifiers=8),
        "right": lambda: drag(button="right", buttons=2),
        "wheel": lambda: browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-200),
        "arrow": lambda: browser.press("ArrowLeft"),
        "plus": lambda: browser.press("+"),
        "minus": lambda: browser.press("-"),
    }
    for name, act in acts.items():
        before, was = shown(browser), json.loads(browser.run(state))
        browser.run(f"{PAGE}.screen.canvas.focus()")
        act()
        now = json.loads(browser.run(state))
        assert now != was, name
        assert (now["target"] != was["target"]) == (name in ("shift", "right")), name
        settled(browser)
        assert (shown(browser) != before).any(), name
        assert browser.run(f"{ROOT}.dataset.picked") is None, name
    browser.press("0")
    settled(browser)
    assert (shown(browser) == first).all()
    # the horizon cannot be turned over
    browser.run(f"for (let i = 0; i < 100; i++) {PAGE}.turn(0, 0.1)")
    settled(browser)


def test_a_pixel_s_rays_sum_to_it(browser: Browser, server: Server) -> None:
    look(browser, server)
    x, y = center(browser)
    for kind in ("mousePressed", "mouseReleased"):
        browser.mouse(kind, x, y, button="left", buttons=1, clickCount=1)
    browser.wait(f"{ROOT}.dataset.picked")
    place = tuple(map(int, browser.run(f"{ROOT}.dataset.picked").split()))
    total, value = browser.run(FILM)
    assert np.float32(total).tolist() == value
    pixels = clrt.Tracer(scene()).render(spp=1).pixels
    assert value == pixels[place[1], place[0]].tolist()
    listed = f"{PAGE}.rays.list.querySelectorAll('details').length"
    assert browser.run(f"{listed} === {PAGE}.rays.tree.rays.length")
    assert EVIL in browser.run(f"{PAGE}.rays.list.textContent")
    before = browser.run(f"{PAGE}.rays.canvas.toDataURL()")
    browser.run(f"{PAGE}.rays.canvas.focus()")
    browser.press("ArrowLeft")
    assert browser.run(f"{PAGE}.rays.canvas.toDataURL()") != before


def test_a_pixel_is_chosen_by_keys(browser: Browser, server: Server) -> None:
    look(browser, server)
    browser.run(f"{PAGE}.screen.canvas.focus()")
    for key in ("p", "ArrowRight", "ArrowDown", "Enter"):
        browser.press(key)
    browser.wait(f"{ROOT}.dataset.picked === '{WIDTH // 2 + 1} {HEIGHT // 2 + 1}'")
    browser.press("Escape")
    assert browser.run(f"{PAGE}.cross.hidden")


def test_sliders_faster_than_pictures(browser: Browser, server: Server) -> None:
    """The last value wins, and the picture is that of a scene with it."""
    look(browser, server)
    place = f'materials."{EVIL}".reflection'
    slide = """(async () => {
      const row = [...document.querySelectorAll(".knob")].find(row => row.dataset.place === PLACE);
      const range = row.querySelector("input[type=range]");
      for (let i = 0; i <= 40; i++) {
        range.value = i / 50;
        range.dispatchEvent(new Event("input"));
        if (i % 4 === 0) await new Promise(done => setTimeout(done, 5));
      }
      return Number(range.value);
    })()"""
    value = browser.run(slide.replace("PLACE", json.dumps(place)))
    assert value == pytest.approx(0.8)
    settled(browser)
    right = encode(clrt.Tracer(scene().replace({place: value})).render(spp=16).pixels).reshape(-1, 3)
    assert np.abs(shown(browser).astype(int) - right).max() <= 1
    browser.run("[...document.querySelectorAll('button')].find(b => b.textContent === 'reset').click()")
    settled(browser)
    right = encode(clrt.Tracer(scene()).render(spp=16).pixels).reshape(-1, 3)
    assert np.abs(shown(browser).astype(int) - right).max() <= 1


def test_layers_and_saved_files(browser: Browser, server: Server) -> None:
    look(browser, server)
    first = shown(browser)
    browser.run(f"{PAGE}.layers.value = 'normal'; {PAGE}.layers.dispatchEvent(new Event('change'))")
    settled(browser)
    assert (shown(browser) != first).any()
    browser.run(
        "window.files = []; HTMLAnchorElement.prototype.click = function () { files.push(this.download); }"
    )
    for word in ("save PNG", "save EXR", "save scene"):
        browser.run(f"[...document.querySelectorAll('button')].find(b => b.textContent === '{word}').click()")
    browser.wait("files.length === 3")
    assert {name.rsplit(".", 1)[1] for name in browser.run("files")} == {"exr", "png", "toml"}


def test_a_fault_is_told_and_the_picture_stays(browser: Browser, server: Server) -> None:
    look(browser, server)
    first = shown(browser)
    browser.run(f"{PAGE}.knobs.changes = {{ nothing: 1 }}; {PAGE}.changed()")
    browser.wait(f"!{PAGE}.fault.hidden")
    assert "'nothing': cannot be changed here" in browser.run(f"{PAGE}.fault.textContent")
    assert (shown(browser) == first).all()
    browser.run(f"{PAGE}.knobs.changes = {{}}; {PAGE}.changed()")
    settled(browser)
    assert browser.run(f"{PAGE}.fault.hidden")


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [180, 360, 1280])
def test_it_can_be_read_everywhere(browser: Browser, server: Server, width: int, dark: bool) -> None:
    look(browser, server, width=width, height=800, dark=dark, touch=width < 400)
    unfold = "document.querySelectorAll('details').forEach(one => { one.open = true; })"
    browser.run(f"{PAGE}.pick(16, 11).then(() => {unfold})")
    assert browser.run("document.documentElement.scrollWidth <= innerWidth")
    small = "[...document.querySelectorAll('.panel select')].filter(one => one.offsetWidth < 40).length"
    assert browser.run(small) == 0
    bad, seen = browser.run(CONTRAST)
    assert bad == "" and seen > 60
    unnamed = """[...document.querySelectorAll("input, select, button, canvas")].filter(
      one => !one.labels?.length && !one.getAttribute("aria-label") && !one.textContent).length"""
    assert browser.run(unnamed) == 0


def test_fingers_turn_and_zoom(browser: Browser, server: Server) -> None:
    look(browser, server, width=390, height=800, touch=True)
    x, y = center(browser)
    stated = f"JSON.stringify({PAGE}.orbit.stated())"
    first = browser.run(stated)
    for kind, points in (("touchStart", [(x, y)]), ("touchMove", [(x + 40, y)]), ("touchEnd", [])):
        browser.touch(kind, *points)
    turned = browser.run(stated)
    assert turned != first and json.loads(turned)["target"] == json.loads(first)["target"]
    for kind, apart in (("touchStart", 20), ("touchMove", 60)):
        browser.touch(kind, (x - apart, y), (x + apart, y))
    browser.touch("touchEnd")
    near, far = (np.subtract(*(json.loads(text)[key] for key in ("origin", "target")))
                 for text in (browser.run(stated), turned))  # fmt: skip
    assert np.linalg.norm(near) < 0.6 * np.linalg.norm(far)


def test_another_page_does_not_reach_it(browser: Browser, server: Server) -> None:
    """Not even with the address: its script, its pictures, a frame of it."""
    with serving(Session(clrt.Tracer(scene()))) as other:
        look(browser, other)
        try:
            tries = f"""(async () => {{
              const found = [];
              for (const how of [{{ method: "POST", body: "{{}}" }}, {{}}, {{ mode: "no-cors" }}]) {{
                const asked = fetch("{server.address}open", how);
                found.push(await asked.then(() => "reached", () => "not"));
              }}
              return found;
            }})()"""
            assert browser.run(tries) == ["not"] * 3
        finally:
            browser.messages.clear()  # the browser tells of each
            browser.requests.clear()
            browser.open("about:blank")
