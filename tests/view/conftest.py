"""A server of the viewer, for all tests of a module."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import clrt
from clrt.view.server import Server
from clrt.view.session import Session
from tests.view_samples import scene, serving


@pytest.fixture(scope="module")
def session() -> Session:
    return Session(clrt.Tracer(scene()))


@pytest.fixture(scope="module")
def server(session: Session) -> Iterator[Server]:
    with serving(session) as found:
        yield found
