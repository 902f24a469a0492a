"""Limits of this process, and what needs more than they leave."""

from __future__ import annotations

import resource
import sys

import pytest

from clrt.base import room
from clrt.base.errors import LimitError
from clrt.base.room import check_addresses, check_room, process_limit

GIB = 1 << 30


@pytest.mark.parametrize(
    ("given", "told"), [(3 * GIB, 3 * GIB), (0, 0), (resource.RLIM_INFINITY, float("inf"))]
)
def test_the_limit_of_a_process_is_told(monkeypatch: pytest.MonkeyPatch, given: int, told: float) -> None:
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (given, resource.RLIM_INFINITY))
    assert process_limit("RLIMIT_AS") == told


def test_a_system_without_such_limits_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    assert process_limit("RLIMIT_OF_ANOTHER_SYSTEM") == float("inf")
    monkeypatch.setitem(sys.modules, "resource", None)
    assert process_limit("RLIMIT_AS") == float("inf")


def test_what_needs_more_addresses_is_refused_with_the_command_that_allows_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(room, "process_limit", lambda name: 2 * GIB)
    check_addresses(2 * GIB, "this")
    with pytest.raises(LimitError, match=r"ulimit -v 2097152: this needs more; allow at least 3145728"):
        check_addresses(3 * GIB, "this")


@pytest.mark.parametrize(("name", "option"), [("RLIMIT_AS", "-v"), ("RLIMIT_DATA", "-d")])
def test_room_for_the_libraries_grows_with_the_cores(
    monkeypatch: pytest.MonkeyPatch, name: str, option: str
) -> None:
    monkeypatch.setattr(room, "process_limit", lambda asked: GIB if asked == name else float("inf"))
    monkeypatch.setattr(room.os, "cpu_count", lambda: 2)
    check_room()
    monkeypatch.setattr(room.os, "cpu_count", lambda: 64)
    with pytest.raises(LimitError, match=f"ulimit {option} 1048576: clrt needs more; allow at least"):
        check_room()
