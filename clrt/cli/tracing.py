"""`--trace FILE`: when each pass, copy and wait was, for Chrome's and Perfetto's viewers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from clrt.base.atomic import write_json


@contextmanager
def tracing(file: str | None) -> Iterator[Callable[[], None]]:
    """Record the drivers that are opened within the block; give what then writes the file."""
    if file is None:
        yield lambda: None
        return
    from clrt.device.timeline import recording

    with recording() as timeline:
        yield lambda: write_json(file, timeline.document())
