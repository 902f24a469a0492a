"""What oracles say of cases, kept from run to run: it takes minutes, and no fault changes it."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from platformdirs import user_cache_dir

from clrt.base.atomic import replacing
from clrt.base.errors import ClrtError
from clrt.base.resources import scene_folder

from ..independence import code

Answer = TypeVar("Answer")


def once(oracle: str, what: Any, make: Callable[[], Answer]) -> Answer:
    """What `make` gives, an oracle's answer; or what an earlier run kept of the same question and code.

    what: the question, all that the answer is made from; its repr tells it from others. Files that a scene
    names count by name, those that ship wherever they are.
    """
    asked = repr(what).replace(str(scene_folder()), "scenes")
    name = hashlib.sha256(f"{code(oracle)} {_harness()} {asked}".encode()).hexdigest()[:32]
    file = Path(user_cache_dir("clrt", appauthor=False)) / "references" / f"{name}.pickle"
    with suppress(OSError, pickle.UnpicklingError, EOFError):
        kept: Answer = pickle.loads(file.read_bytes())
        return kept
    made = make()
    with suppress(OSError, ClrtError):  # only time is lost
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with replacing(file) as temporary:
            temporary.write_bytes(pickle.dumps(made))
    return made


@cache
def _harness() -> str:
    """Of what asks the oracles."""
    texts = [Path(__file__).parents[1].joinpath(name).read_bytes() for name in ("oracles.py", "types.py")]
    return hashlib.sha256(b"".join(texts)).hexdigest()
