"""Which features a case shows: those without which its picture is another one, as was measured and kept.

`ticks.json` has for each case what its picture was when `python -m validation.deletion_run` measured it, and
which of its features it shows. A case whose row does not fit it any more shows nothing.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from clrt.base.atomic import write_text

from .types import Case

Row = dict[str, Any]  # "scene": digest, "asked" and "shows": features, "code": digest of what measured it
FILE: Final = Path(__file__).with_name("ticks.json")


@cache
def kept() -> Mapping[str, Row]:
    """The rows of `ticks.json` by case."""
    return dict(json.loads(FILE.read_text("utf-8"))) if FILE.is_file() else {}


def row(case: Case, shows: Iterable[str], code: str = "") -> Row:
    """What is kept of a case. code: the digest of what measured it."""
    return {"scene": digest(case), "asked": sorted(case.features), "shows": sorted(shows), "code": code[:16]}


def fits(case: Case) -> bool:
    """Whether a case was measured with the scene and the features that it has."""
    found = kept().get(case.name)
    return found is not None and found["scene"] == digest(case) and found["asked"] == sorted(case.features)


def shown(case: Case) -> frozenset[str]:
    """Those of a case's features that were measured to show; none where the case has changed since."""
    return frozenset(kept()[case.name]["shows"]) if fits(case) else frozenset()


def digest(case: Case) -> str:
    """What identifies a case's picture."""
    picture = [case.scene, case.width, case.height, case.spp, case.max_depth]
    text = json.dumps(picture, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def write(rows: Mapping[str, Row], matrix: Iterable[str]) -> None:
    """Keep the rows of cases that there are, a line each."""
    lines = [f"{json.dumps(name)}: {json.dumps(rows[name])}" for name in matrix if name in rows]
    write_text(FILE, "{\n" + ",\n".join(lines) + "\n}\n")
