"""The notebook's widget answers as the page's server does; scenes and tracers show themselves."""

from __future__ import annotations

import sys
import threading
from types import ModuleType
from typing import Any

import pytest

import clrt
from clrt.base import display
from clrt.view.session import Session
from tests.view_samples import EVIL, SCENE, SIZE, scene

FRAME = {"page": "p", "width": SIZE[0], "height": SIZE[1], "spp": 1}


class Talk:
    """A notebook's side of a widget's messages."""

    def __init__(self, view: Any) -> None:
        self.view, self.count = view, 0
        self.answers: dict[int, tuple[dict[str, Any], bytes]] = {}
        self.heard = threading.Condition()
        view.send = self._hear

    def _hear(self, message: dict[str, Any], buffers: list[bytes]) -> None:
        with self.heard:
            self.answers[message["id"]] = message["table"], buffers[0]
            self.heard.notify()

    def ask(self, kind: str, **body: Any) -> tuple[dict[str, Any], bytes]:
        self.count += 1
        self.view._handle_custom_msg({"id": self.count, "kind": kind, "body": body}, [])
        with self.heard:
            assert self.heard.wait_for(lambda: self.count in self.answers, 60)
            return self.answers[self.count]


@pytest.fixture(scope="module")
def talk() -> Talk:
    pytest.importorskip("anywidget", reason="needs the optional dependency clrt[notebook]")
    return Talk(clrt.widget(scene()))


def test_it_answers_as_the_server_does(talk: Talk) -> None:
    assert talk.view.scene == scene()
    session = Session(clrt.Tracer(scene()))
    assert talk.ask("open") == session.answer("open", {})
    place = f'materials."{EVIL}".reflection'
    asked = {**FRAME, "changes": {place: 0.1}, "camera": {"origin": [2, 1, 4]}}
    assert talk.ask("frame", number=1, **asked) == session.answer("frame", {"number": 1, **asked})
    assert talk.view.scene == scene().replace({place: 0.1, "camera.origin": [2, 1, 4]})
    assert talk.ask("frame", number=0, **asked)[0] == {"superseded": True}
    assert "cannot be changed here" in talk.ask("frame", number=2, **FRAME, changes={"x": 1})[0]["error"]
    assert "is no question" in talk.ask("nothing")[0]["error"]
    assert talk.view.scene.camera.origin == (2.0, 1.0, 4.0)
    talk.view._handle_custom_msg("no table", [])


def test_its_module_is_the_page_s(talk: Talk) -> None:
    from clrt.view.web import module, style

    assert (talk.view._esm, talk.view._css) == (module(), style())
    assert "export default { render }" in module() and module().count("export ") == 1
    assert "import " not in module() and "http" not in module().replace("OverHttp", "")


def test_what_has_no_camera_or_no_anywidget_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(clrt.SceneError, match="camera: missing; to look at the scene it needs a"):
        clrt.widget({"shapes": SCENE["shapes"][1:2] and [{**SCENE["shapes"][1], "material": {}}]})
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(clrt.ClrtError, match="widget: needs anywidget; install it with: "):
        clrt.widget(scene())


FAULTS = [(MemoryError(), "no memory left"), (ZeroDivisionError("by 0"), "ZeroDivisionError: by 0")]


@pytest.mark.parametrize(("error", "said"), FAULTS)
def test_a_page_never_waits_for_what_failed(
    error: Exception, said: str, talk: Talk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise error

    monkeypatch.setattr(talk.view._session, "answer", fails)
    assert said in talk.ask("open")[0]["error"]


def test_a_message_that_does_not_fit_into_memory_is_said(
    talk: Talk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A notebook copies it."""

    def send(message: dict[str, Any], buffers: list[bytes]) -> None:
        if "error" not in message["table"]:
            raise MemoryError
        talk._hear(message, buffers)

    monkeypatch.setattr(talk.view, "send", send)
    assert "no memory left" in talk.ask("open")[0]["error"]


# --- what notebooks show by themselves


def test_scenes_and_tracers_show_themselves(monkeypatch: pytest.MonkeyPatch) -> None:
    made = scene()
    html = made._repr_html_()
    assert "<script" not in html and "&lt;script&gt;" in html and "2 sphere" in html and "1 point" in html
    tracer = clrt.Tracer(made)
    shown = tracer._repr_html_()
    assert "<script" not in shown and 'src="data:image/png;base64,' in shown
    assert tracer.device.info.name.split()[0] in shown
    for one, page in ((made, html), (tracer, shown)):
        assert one._repr_mimebundle_() == {"text/html": page}  # outside of a notebook
    blind = {name: value for name, value in SCENE.items() if name != "camera"}
    assert "<img" not in clrt.Tracer(blind)._repr_html_()
    dark = clrt.load_dict(blind | {"camera": {**SCENE["camera"], "width": 5}}, limits=clrt.Limits(work=1))
    assert (
        "no picture: "
        in clrt.Tracer(dark, settings=clrt.Settings(limits=clrt.Limits(work=1)))._repr_html_()
    )


def test_notebooks_get_the_widget(talk: Talk, monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = ModuleType("ipykernel")
    kernel.version_info = (7, 0, 0)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ipykernel", kernel)
    tracer = clrt.Tracer(scene())
    for one in (scene(), tracer):
        bundle = one._repr_mimebundle_()
        assert set(bundle) == {"text/html", "application/vnd.jupyter.widget-view+json"}
    assert tracer.scene.camera is not None
    blind = clrt.load_dict({name: value for name, value in SCENE.items() if name != "camera"})
    assert set(blind._repr_mimebundle_()) == {"text/html"}
    monkeypatch.setattr(display, "live", lambda shown: {})
    assert set(scene()._repr_mimebundle_()) == {"text/html"}
