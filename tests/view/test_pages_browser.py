"""Other pages in a real browser: the notebook's widget is one; nothing that a scene says is run in any."""

from __future__ import annotations

import base64
import json
import re
import time
from pathlib import Path
from typing import Any

import pytest

import clrt
from browser import Browser
from tests.view_samples import EVIL, scene

pytestmark = pytest.mark.browser

HOST = """(async (code, css) => {
  const style = document.createElement("style");
  style.textContent = css;
  document.head.append(style);
  window.outbox = [];
  const heard = new Set();
  const model = {
    send: message => outbox.push(message), on: (kind, f) => heard.add(f), off: (kind, f) => heard.delete(f),
  };
  window.deliver = (message, data) => {
    const bytes = Uint8Array.from(atob(data), c => c.charCodeAt(0));
    heard.forEach(f => f(message, [new DataView(bytes.buffer)]));
  };
  const widget = await import(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
  window.el = document.body.appendChild(document.createElement("div"));
  window.close_widget = widget.default.render({ model, el });
})"""


def test_the_widget_shows_and_turns(chromium: Browser, tmp_path: Path) -> None:
    """In the place of a notebook: a page with nothing but anywidget's model."""
    pytest.importorskip("anywidget", reason="needs the optional dependency clrt[notebook]")
    from clrt.view.web import module, style

    sent: list[tuple[Any, bytes]] = []
    view = clrt.widget(scene())
    view.send = lambda message, buffers: sent.append((message, buffers[0]))
    (tmp_path / "host.html").write_text("<!doctype html><title>host</title>")
    chromium.open((tmp_path / "host.html").as_uri())
    chromium.run(f"{HOST}({json.dumps(module())}, {json.dumps(style())})")

    def talk(until: str) -> None:
        deadline = time.monotonic() + 60
        while not chromium.run(f"!!({until})"):
            assert time.monotonic() < deadline, (until, chromium.messages)
            for message in chromium.run("outbox.splice(0)"):
                view._handle_custom_msg(message, [])
            while sent:
                message, data = sent.pop(0)
                chromium.run(f"deliver({json.dumps(message)}, '{base64.b64encode(data).decode()}')")

    talk("el.clrtView && el.clrtView.frame && el.clrtView.frame.spp === 16")
    first = chromium.run("el.clrtView.screen.canvas.toDataURL()")
    chromium.run("el.clrtView.turn(0.4, 0.1)")
    talk("el.clrtView.frame.version === 2 && el.clrtView.frame.spp === 16")
    assert chromium.run("el.clrtView.screen.canvas.toDataURL()") != first
    assert view.scene.camera.origin == pytest.approx(chromium.run("el.clrtView.orbit.origin"))
    chromium.run("void el.clrtView.pick(16, 11)")
    talk("el.querySelector('.clrt-view').dataset.picked")
    assert EVIL in chromium.run("el.textContent")
    ground = "getComputedStyle(document.querySelector('.clrt-view')).backgroundColor"
    for light, colour in (("true", "rgb(255, 255, 255)"), ("false", "rgb(20, 23, 26)")):  # JupyterLab's theme
        chromium.run(f"document.body.dataset.jpThemeLight = '{light}'")
        assert chromium.run(ground) == colour
    chromium.run("close_widget()")
    assert chromium.run("el.children.length") == 0
    assert chromium.messages == [] and chromium.run("window.evil === undefined")


def test_nothing_runs_in_the_other_pages(chromium: Browser, tmp_path: Path) -> None:
    """The page of a pixel, the report of a comparison, and what notebooks are given."""
    tracer = clrt.Tracer(scene())
    tree = tracer.explain(16, 11, spp=1)
    verdict = clrt.compare(tracer.render(spp=1), scene(), seconds=0.01)
    fragments = [tree._repr_html_(), scene()._repr_html_(), tracer._repr_html_()]
    (tmp_path / "notebook.html").write_text(f"<!doctype html><meta charset=utf-8>{''.join(fragments)}")
    files = [
        tree.save(tmp_path / "tree.html"),
        Path(verdict.save_report(tmp_path / "report.html")),
        tmp_path / "notebook.html",
    ]
    for file in files:
        chromium.open(file.as_uri())
        assert chromium.run("window.evil === undefined") and chromium.messages == []
        if file.name != "report.html":
            assert EVIL in chromium.run("document.body.textContent")
        assert not [url for url in chromium.requests if re.search(r"/x$", url)]
