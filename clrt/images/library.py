"""OpenImageIO, loaded when it is first used: checks that a picture can be saved need not wait for it.

`from clrt.images import library as oiio` stands for `import OpenImageIO as oiio`.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def __getattr__(name: str) -> Any:
    return getattr(import_module("OpenImageIO"), name)
