"""`--cluster` of the commands that render."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from clrt.device.settings import Settings


@contextmanager
def cluster(options: argparse.Namespace, settings: Settings) -> Iterator[tuple[dict[str, Any], Settings]]:
    """What `clrt.render` is given besides: {"executor": ...}, or nothing without --cluster; and settings."""
    address = getattr(options, "cluster", None)
    if address is None:
        yield {}, settings
        return
    from clrt.cluster.connect import connected

    with connected(address, settings) as (executor, shared):
        yield {"executor": executor}, shared
