"""The suite's page in a real browser: its pictures, its slider, its zoom; by mouse, keyboard and finger."""

from __future__ import annotations

import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import report_samples as samples
from browser import Browser
from clrt.base.resources import validation_module
from report_viewer import CANVAS, CONTRAST, VIEWER, WRONG, box, bytes_of, differing, drawn, look, place, state

pytestmark = pytest.mark.browser
report = validation_module("suite.report")


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = report.write_report(samples.result(), tmp_path_factory.mktemp("page") / "report.html")
    return path.as_uri()


@pytest.fixture
def browser(chromium: Browser, page: str) -> Iterator[Browser]:
    """The browser; whatever a test does, the console stays empty and nothing is fetched."""
    yield chromium
    assert chromium.messages == []
    assert {url.split(":")[0] for url in chromium.requests} <= {"file", "data"}
    assert sum(url.startswith("file:") for url in chromium.requests) <= 1


def test_all_pages_load_without_a_word(browser: Browser, page: str):
    for dark in (False, True):
        for width in (390, 1280):
            look(browser, page, width=width, dark=dark)
            browser.run("document.querySelectorAll('details').forEach(details => { details.open = true; })")
            browser.wait("[...document.querySelectorAll('.viewer')].every(viewer => viewer.dataset.ready)")
            assert browser.messages == []


def test_the_slider_parts_ours_from_the_reference(browser: Browser, page: str):
    look(browser, page)
    (x, y), (ours, reference) = differing(), bytes_of()
    assert state(browser)["view"] == "slider"
    slider = f"{VIEWER}.querySelector('.split')"
    for value, picture in (((x + 8) / 160, ours), ((x - 8) / 160, reference)):
        browser.run(f"{slider}.value = {value}; {slider}.dispatchEvent(new Event('input'))")
        assert drawn(browser, x, y) == picture[y, x].tolist()
    browser.run(f"{slider}.focus()")
    before = float(state(browser)["split"])
    for _ in range(5):
        browser.press("ArrowRight")
    assert float(state(browser)["split"]) > before
    browser.drag(place(browser, 100, 20), place(browser, 40, 30))
    assert float(state(browser)["split"]) == pytest.approx(40.5 / 160, abs=0.01)


def test_flicker_shows_both_in_turn(browser: Browser, page: str):
    look(browser, page)
    (x, y), (ours, reference) = differing(), bytes_of()
    browser.run(f"{VIEWER}.querySelector('input[value=flicker]').click()")
    for picture in (ours, reference, ours):
        deadline = time.monotonic() + 10
        while drawn(browser, x, y) != picture[y, x].tolist():
            assert time.monotonic() < deadline


def test_nothing_moves_for_who_wants_it_still(browser: Browser, page: str):
    look(browser, page, still=True)
    (x, y), (ours, reference) = differing(), bytes_of()
    browser.run(f"{CANVAS}.focus()")
    browser.press("2")
    assert state(browser)["view"] == "flicker"
    browser.run("new Promise(done => setTimeout(done, 1500))")
    assert drawn(browser, x, y) == ours[y, x].tolist()
    browser.press(" ")
    assert drawn(browser, x, y) == reference[y, x].tolist()


def numbers(text: str, row: str) -> list[float]:
    line = next(line for line in text.splitlines() if line.startswith(row))
    return [float(number.replace("−", "-")) for number in re.findall(r"[+−-]?\d[\d.e+-]*", line)]


def test_the_values_under_the_pointer_are_the_pixel_s(browser: Browser, page: str):
    look(browser, page)
    case = samples.result().cases[WRONG]
    image, found = case.results["oracle64"]
    for x, y in (differing(), (3, 2), (159, 119)):
        browser.mouse("mouseMoved", *place(browser, x, y))
        text = browser.run(f"{VIEWER}.querySelector('.values').textContent")
        assert f"pixel ({x}, {y})" in text and ("on an edge" in text) == bool(found.maps["mask"][y, x])
        assert numbers(text, "ours") == pytest.approx(case.ours.pixels[y, x].tolist(), abs=0.005)
        assert numbers(text, "oracle") == pytest.approx(image.pixels[y, x].tolist(), abs=0.005)
        if np.abs(found.maps["difference"][y, x]).min() > 1e-4:
            assert numbers(text, "apart") == pytest.approx(found.maps["difference"][y, x].tolist(), rel=0.1)
        flip, ssim = re.search(r"FLIP ([\d.e-]+) +SSIM ([\d.-]+)", text).groups()
        assert float(flip) == pytest.approx(found.maps["flip"][y, x], abs=0.01)
        assert float(ssim) == pytest.approx(found.maps["ssim"][y, x], abs=0.01)


def test_maps_show_where_it_differs(browser: Browser, page: str):
    look(browser, page)
    (x, y), case = differing(), samples.result().cases[WRONG]
    difference = case.results["oracle64"][1].maps["difference"][y, x]
    browser.run(f"{VIEWER}.querySelector('input[value=difference]').click()")
    browser.run(f"{CANVAS}.focus()")
    red, _, blue = drawn(browser, x, y)
    assert (red > blue) == (difference[np.abs(difference).argmax()] > 0) and max(red, blue) > 150
    assert max(drawn(browser, 3, 3)) < 60, "equal is dark"
    told = f"{VIEWER}.querySelector('.legend').textContent"
    assert "ours darker" in browser.run(told)
    for key, end in (("6", "0 equal"), ("7", "1 equal")):
        browser.press(key)
        assert browser.run(told).startswith(end)
        assert sum(drawn(browser, x, y)) > sum(drawn(browser, 3, 3)) + 60
    browser.press("3")
    assert browser.run(told) == "", "pictures need none"
    browser.press("5")
    plain = drawn(browser, 3, 3)
    mask = case.results["oracle64"][1].maps["mask"]
    row, column = np.argwhere(mask > 0)[0]
    before = drawn(browser, column, row)
    browser.press("e")
    assert drawn(browser, column, row) != before and drawn(browser, 3, 3) == plain


def test_zoom_by_wheel_buttons_keys_and_double_click(browser: Browser, page: str):
    look(browser, page)
    x, y = differing()
    at = place(browser, x, y)

    def under() -> str:
        browser.mouse("mouseMoved", *at)
        return str(browser.run(f"{VIEWER}.querySelector('.values').textContent")).splitlines()[0]

    wheel = {"deltaX": 0, "deltaY": -500}
    start = browser.run("scrollY")
    browser.mouse("mouseWheel", *at, deltaX=0, deltaY=40)
    browser.wait(f"scrollY > {start}")
    assert state(browser)["zoom"] == "1", "the wheel belongs to the page until the picture is chosen"
    look(browser, page)
    browser.run(f"{CANVAS}.focus()")
    browser.mouse("mouseWheel", *at, **wheel)
    browser.wait(f"Number({VIEWER}.dataset.zoom) === 4")
    assert under().startswith(f"pixel ({x}, {y})"), "what is under the pointer stays there"
    browser.press("0")
    assert state(browser)["zoom"] == "1"
    browser.press("+")
    browser.press("+")
    browser.press("-")
    assert state(browser)["zoom"] == "2"
    for label, zoom in (("Zoom in", "4"), ("Zoom out", "2"), ("Show all", "1")):
        browser.run(f"{VIEWER}.querySelector('button[aria-label=\"{label}\"]').click()")
        assert state(browser)["zoom"] == zoom
    click = {"button": "left", "buttons": 1}
    for count in (1, 2):
        browser.mouse("mousePressed", *at, **click, clickCount=count)
        browser.mouse("mouseReleased", *at, **click, clickCount=count)
    assert state(browser)["zoom"] == "2"
    for _ in range(10):
        browser.press("+")
    assert state(browser)["zoom"] == "64"
    assert len({tuple(drawn(browser, i, 60)) for i in range(0, 160, 2)}) > 4, (
        "values are written into the pixels"
    )


def test_a_zoomed_picture_can_be_moved(browser: Browser, page: str):
    look(browser, page)
    browser.run(f"{CANVAS}.focus()")
    browser.press("5")
    for _ in range(3):
        browser.press("+")
    at = place(browser, 80, 60)
    browser.mouse("mouseMoved", *at)
    before = browser.run(f"{VIEWER}.querySelector('.values').textContent")
    browser.drag(at, place(browser, 40, 60))
    browser.mouse("mouseMoved", *at)
    after = browser.run(f"{VIEWER}.querySelector('.values').textContent")
    first, second = (int(re.search(r"pixel \((\d+)", text).group(1)) for text in (before, after))
    assert second - first == pytest.approx(40 / 8, abs=1)


def test_everything_by_keyboard(browser: Browser, page: str):
    browser.open(page)
    seen = []
    for _ in range(60):
        browser.press("Tab")
        seen.append(
            browser.run("document.activeElement.closest('.case')?.id || document.activeElement.className")
        )
        if seen[-1] == f"case-{WRONG}":
            break
    assert seen[0] == "skip" and seen[-1] == f"case-{WRONG}"
    assert browser.run("getComputedStyle(document.activeElement).outlineStyle") == "solid", (
        "focus can be seen"
    )
    browser.press("Enter")
    browser.wait(f"{VIEWER}.dataset.ready")
    browser.press("Tab")
    for _ in range(4):
        browser.press("ArrowRight")
    assert state(browser)["view"] == "difference", "radio buttons go by arrows"
    for _ in range(8):
        browser.press("Tab")
        if browser.run(f"document.activeElement === {CANVAS}"):
            break
    browser.press("1")
    assert state(browser)["view"] == "slider"
    browser.press(".")
    assert float(state(browser)["split"]) == pytest.approx(0.52)
    browser.press("ArrowLeft")
    browser.press("ArrowUp", modifiers=8)
    assert browser.run(f"{VIEWER}.querySelector('.values').textContent").startswith("pixel (79, 50)")
    assert browser.run(f"{VIEWER}.querySelector('.values').ariaLive") == "polite", "told to who cannot see it"
    browser.press("Tab")
    assert browser.run(f"document.activeElement === {VIEWER}.querySelector('.split')"), "no trap"


def test_a_run_without_flip_has_the_other_views(browser: Browser, tmp_path: Path):
    path = report.write_report(samples.without_flip(samples.result()), tmp_path / "report.html")
    look(browser, path.as_uri())
    views = f"[...{VIEWER}.querySelectorAll('input[type=radio]')].map(radio => radio.value).join()"
    assert browser.run(views) == "slider,flicker,ours,reference,difference,ssim"
    browser.run(f"{CANVAS}.focus()")
    browser.press("6")
    assert state(browser)["view"] == "ssim"
    text = browser.run(f"{VIEWER}.querySelector('.values').textContent")
    assert "SSIM" in text and "FLIP" not in text


def test_another_oracle_can_be_chosen(browser: Browser, page: str):
    look(browser, page)
    choose = "s => { s.value = 'mitsuba-table'; s.dispatchEvent(new Event('change')); }"
    browser.run(f"({choose})({VIEWER}.querySelector('select'))")
    browser.wait(f"{VIEWER}.dataset.ready === 'mitsuba-table'")


def test_cases_can_be_found(browser: Browser, page: str):
    browser.open(page)
    visible = "[...document.querySelectorAll('.case')].filter(c => !c.hidden).map(c => c.id).join()"
    assert browser.run(visible) == "case-0,case-1,case-2,case-3"
    browser.run("document.getElementById('find').focus()")
    for letter in "index":
        browser.press(letter)
    assert browser.run(visible) == "case-2"
    assert browser.run("document.getElementById('shown').textContent") == "1 of 4 cases"
    browser.run("document.getElementById('find').value = 'FRESNEL'; filter()")
    assert browser.run(visible) == "case-0,case-1,case-2,case-3"
    browser.run("document.getElementById('only-failed').click()")
    assert browser.run(visible) == "case-2"
    browser.run("document.querySelector('.failures a').click()")
    browser.wait("document.getElementById('case-2').open")


@pytest.mark.parametrize("dark", [False, True])
def test_texts_stand_out_from_what_is_behind(browser: Browser, page: str, dark: bool):
    look(browser, page, dark=dark)
    assert browser.run("getComputedStyle(document.body).backgroundColor") == (
        "rgb(20, 23, 27)" if dark else "rgb(255, 255, 255)"
    )
    bad, seen = browser.run(CONTRAST)
    assert bad == "" and seen > 200


def test_on_a_phone(browser: Browser, page: str):
    look(browser, page, width=390, height=844, touch=True)
    assert browser.run("document.documentElement.scrollWidth") == 390, "nothing sticks out sideways"
    assert box(browser)[2] > 300
    small = "[...document.querySelectorAll('button, select, .viewer label, summary')]"
    height = "e => e.checkVisibility() ? e.getBoundingClientRect().height : 99"
    assert browser.run(f"Math.min(...{small}.map({height}))") >= 24
    x, y = place(browser, 80, 60)
    browser.touch("touchStart", (x - 20, y), (x + 20, y))
    for step in range(1, 6):
        browser.touch("touchMove", (x - 20 - 8 * step, y), (x + 20 + 8 * step, y))
    browser.touch("touchEnd")
    assert float(state(browser)["zoom"]) == pytest.approx(3, rel=0.25), "two fingers zoom"


def test_without_javascript_all_figures_are_there(page: str):
    text = Path(page.removeprefix("file://")).read_text("utf-8")
    assert "<noscript>" in text and text.count("<table") > 8 and "generation 2, transmission" in text


def test_a_screenshot_shows_the_case(browser: Browser, page: str, tmp_path: Path):
    look(browser, page)
    browser.run(f"document.getElementById('case-{WRONG}').scrollIntoView()")
    browser.screenshot(tmp_path / "report.png")
    from PIL import Image

    shot = np.asarray(Image.open(tmp_path / "report.png").convert("RGB"))
    assert shot.shape == (900, 1280, 3) and len(np.unique(shot.reshape(-1, 3), axis=0)) > 500
    out = Path(__file__).resolve().parents[2] / "out"
    out.mkdir(exist_ok=True)
    shutil.copy(tmp_path / "report.png", out / "report.png")


def test_no_figure_is_cut_on_a_telephone(browser: Browser, page: str):
    look(browser, page, width=390)
    browser.run("document.querySelectorAll('details').forEach(details => { details.open = true; })")
    cut = """[...document.querySelectorAll('.stack')].filter(table => {
        const box = table.parentElement;
        const cells = [...table.querySelectorAll('td')];
        return !cells.length || box.scrollWidth > box.clientWidth
            || cells.some(cell => cell.getBoundingClientRect().right > innerWidth);
    }).length"""
    assert browser.run("document.querySelectorAll('.stack').length") >= 3
    assert browser.run(cut) == 0
    assert browser.run("document.documentElement.scrollWidth <= innerWidth")
