"""The notebook's widget: the page's ES module, asking by the notebook's own messages."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from typing import Any, Final

import anywidget

from clrt.base.errors import NO_MEMORY, legible
from clrt.engine.tracer import Tracer
from clrt.scene.scene import Scene
from clrt.view.session import Session, answered
from clrt.view.web import module, style

_QUESTIONS: Final = 8  # answered at a time; a picture waits for the one that it supersedes


class View(anywidget.AnyWidget):
    """A scene to turn, to change and to look into. `scene` is what it shows now."""

    _esm = module()
    _css = style()

    def __init__(self, scene: Scene, open_tracer: Callable[[], Tracer]) -> None:
        super().__init__()
        self._first, self._open = scene, open_tracer
        self._shown: dict[str, Any] = {}
        self._threads = ThreadPoolExecutor(_QUESTIONS, "clrt-view")
        self._sending = threading.Lock()
        self.on_msg(self._ask)

    @cached_property
    def _session(self) -> Session:
        with self._sending:  # one thread makes it
            made = self.__dict__.get("_session")
            return made if isinstance(made, Session) else Session(self._open())

    @property
    def scene(self) -> Scene:
        """The scene with the changes and the camera that are shown."""
        if not self._shown:
            return self._first
        scene, camera = self._session.shown(self._shown)
        return scene.replace({"camera": camera})

    def _ask(self, widget: Any, message: Any, buffers: Any) -> None:
        """A notebook hands over one message after the other, so each is answered in a thread of its own."""
        if isinstance(message, dict):
            self._threads.submit(self._answer, message)

    def _answer(self, message: dict[str, Any]) -> None:
        kind, body = message.get("kind"), message.get("body")
        try:
            table, data = answered(lambda: self._session.answer(str(kind), body))
        except Exception as error:  # nobody hears of it in this thread, and the page would wait for ever
            table, data = {"error": legible(f"{type(error).__name__}: {error}")}, b""
        if kind == "frame" and isinstance(body, dict) and "error" not in table and "superseded" not in table:
            self._shown = {name: body[name] for name in ("camera", "changes") if name in body}
        with self._sending:
            try:
                self.send({"id": message.get("id"), "table": table}, [data])
            except MemoryError:  # a notebook copies it; the page waits until it hears something
                self.send({"id": message.get("id"), "table": {"error": NO_MEMORY}}, [b""])
