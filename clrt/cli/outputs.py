"""Files that a command writes: none of them may take the place of what it reads, or of another one.

Twice: before anything is computed by the names that are known, and whenever a file is replaced by all that
was read until then (`clrt.base.inputs`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from clrt.base.errors import ClrtError
from clrt.base.inputs import Name, identity, noted

if TYPE_CHECKING:
    from clrt.scene.scene import Scene


def check_apart(outputs: Mapping[str, Name | None], inputs: Mapping[str, Name | None]) -> None:
    """ClrtError where an output (by option) is one of the inputs (by what they are) or another output.

    What was read already counts among the inputs; None is a file that was not given.
    """
    taken = {identity(file): what for what, file in inputs.items() if file is not None}
    for found, name in noted().items():
        taken.setdefault(found, f"{name}, which is read")
    for option, file in outputs.items():
        if file is None:
            continue
        what = taken.setdefault(identity(file), f"the file of {option}")
        if what != f"the file of {option}":
            raise ClrtError(f"{file}: is {what}; give {option} a file of its own")


def check_spares(outputs: Mapping[str, Name | None], scene: Scene) -> None:
    """ClrtError where an output would take the place of what belongs to the scene, which has been loaded."""
    background = scene.background_path
    check_apart(outputs, {f"{background}, which the scene reads": background})
