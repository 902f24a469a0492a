"""Make the pictures of docs/viewer.md, of a pixel's page and of the site, and time the viewer.

    python docs/make_view.py [pictures|times|notebook|site]

It looks at the showcase in the headless chromium of tests/browser.py, and prints pictures a second while the
camera moves all the time, beside what the processor did for each, which does not depend on what else runs.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "tests")]

import clrt  # noqa: E402
from browser import Browser  # noqa: E402
from clrt.view.server import Server  # noqa: E402
from clrt.view.session import Session  # noqa: E402

SCENE = "showcase"
PAGE = "document.querySelector('#clrt-view-page').clrtView"
PIXEL = (808.5 / 1280, 353.5 / 720)  # of the picture: the first highlight of docs/explain.md
SECONDS = 5.0
CELL = f'import clrt\n\nscene = clrt.load("{SCENE}")\nscene'
PORT = 18888


def settled(browser: Browser, samples: int = 16) -> None:
    now = "v.frame && !v.pictures.busy && v.frame.version === v.pictures.version"
    browser.wait(f"(v => v && {now} && v.frame.spp === {samples})({PAGE})", 300)


def pick(browser: Browser) -> None:
    x, y = PIXEL
    browser.run(f"{PAGE}.pick({PAGE}.width * {x}, {PAGE}.height * {y})")
    browser.run("new Promise(done => setTimeout(done, 300))")


def pictures(browser: Browser, server: Server) -> None:
    browser.open(server.address, width=1280, height=860)
    settled(browser)
    pick(browser)
    browser.screenshot(HERE / "view.png")
    browser.open(server.address, width=1280, height=860, dark=True)
    settled(browser)
    browser.run("document.querySelectorAll('.panel').forEach((panel, i) => { panel.open = i === 3; })")
    browser.run("[...document.querySelectorAll('.panel details')][5].open = true")
    browser.screenshot(HERE / "view-sliders.png")
    browser.open(server.address, width=390, height=844, touch=True)
    settled(browser)
    pick(browser)
    browser.screenshot(HERE / "view-phone.png")
    tree = clrt.Tracer(SCENE).explain(986, 510, spp=1)
    with tempfile.TemporaryDirectory() as folder:
        page = tree.save(Path(folder) / "why.html").as_uri()
        browser.open(page, width=1100, height=860)
        browser.screenshot(HERE / "explain-page.png")
        browser.open(page, width=390, height=844, touch=True)
        browser.screenshot(HERE / "explain-page-phone.png")


def notebook(browser: Browser) -> None:
    """The widget in JupyterLab, where that is installed."""
    lab = shutil.which("jupyter-lab")
    if lab is None:
        print("no JupyterLab here: docs/view-notebook.png stays as it is")
        return
    cell = {"cell_type": "code", "execution_count": None, "id": "a", "metadata": {}, "outputs": []}
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    page = {"cells": [cell | {"source": CELL}], "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    options = ("--no-browser", "--allow-root", f"--port={PORT}", "--IdentityProvider.token=look")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "look.ipynb").write_text(json.dumps(page))
        process = subprocess.Popen([lab, *options, f"--notebook-dir={folder}"], stderr=subprocess.DEVNULL)
        try:
            for _ in range(60):
                time.sleep(1)
                browser.open(f"http://127.0.0.1:{PORT}/doc/tree/look.ipynb?token=look", 1200, 800)
                if browser.run("document.title !== '' && !!document.querySelector('script')"):
                    break
            browser.wait("document.querySelector('.jp-Cell .cm-content')", 90)
            time.sleep(3)
            browser.run("document.querySelector('.jp-Cell .cm-content').focus()")
            browser.press("Enter", modifiers=8, code="Enter")
            browser.wait("document.querySelector('.clrt-view')?.dataset.spp === '16'", 120)
            browser.run("[...document.querySelectorAll('button')].find(b => b.innerText === 'No')?.click()")
            tab = "document.querySelector('.jp-SideBar.jp-mod-left .lm-mod-current')?.getBoundingClientRect()"
            place = browser.run(f"(box => box && [box.x + box.width / 2, box.y + box.height / 2])({tab})")
            if place:
                browser.drag(place, place)  # a click: the list of files goes away
            time.sleep(3)
            browser.screenshot(HERE / "view-notebook.png")
            browser.resize(390, 844)
            time.sleep(3)
            browser.run("document.querySelector('.clrt-view').scrollIntoView()")
            browser.screenshot(HERE / "view-notebook-phone.png")
        finally:
            process.terminate()
            process.wait(30)


def site(browser: Browser) -> None:
    """The scenes on the site, where `make docs` was run."""
    scenes = HERE.parent / "out/docs/scenes.html"
    if not scenes.exists():
        print("no out/docs here: docs/site.png stays as it is; `make docs` makes it")
        return
    browser.open(scenes.as_uri(), 1280, 800)
    browser.screenshot(HERE / "site.png")


def times(browser: Browser, server: Server) -> None:
    browser.open(server.address, width=1280, height=860)
    browser.wait(f"{PAGE} && {PAGE}.frame", 120)
    for how in ("full", "coarse"):
        browser.run(f"{PAGE}.width = 320; {PAGE}.pictures.moving = '{how}'; {PAGE}.resized()")
        settled(browser)
        before = time.process_time()
        count, seconds = browser.run(f"""(async view => {{
          const frames = () => view.pictures.frames[{int(how == "full")}];
          const first = frames(), begun = performance.now(), took = () => (performance.now() - begun) / 1000;
          while (took() < {SECONDS}) {{
            view.turn(0.01, 0);
            await new Promise(done => setTimeout(done, 16));
          }}
          return [frames() - first, took()];
        }})({PAGE})""")
        spent = (time.process_time() - before) / max(count, 1)
        print(f"{how}: {count / seconds:.1f} pictures a second, {1000 * spent:.0f} ms of processor time each")


def main() -> None:
    only = sys.argv[1] if len(sys.argv) > 1 else None
    with Server(Session(clrt.Tracer(SCENE))) as server, tempfile.TemporaryDirectory() as profile:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with Browser(Path(profile)) as browser:
            if only in (None, "pictures"):
                pictures(browser, server)
            if only in (None, "times"):
                times(browser, server)
        server.shutdown()
    if only in (None, "notebook"):
        with tempfile.TemporaryDirectory() as profile, Browser(Path(profile)) as browser:
            notebook(browser)
    if only in (None, "site"):
        with tempfile.TemporaryDirectory() as profile, Browser(Path(profile)) as browser:
            site(browser)


if __name__ == "__main__":
    main()
