"""Series of pictures, looked at before the first is made: what a later one would be refused for is told then.

For each its scene is made and flattened, and the request is held against it. That takes a part of what
`Tracer.update` takes for each later.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final

from clrt.base import notices
from clrt.base.errors import ClrtError
from clrt.device.settings import Settings
from clrt.engine import tree
from clrt.engine.request import Request
from clrt.flatten.flatten import FlatScene, check_ceilings, flatten
from clrt.scene.adaptive import check_uneven
from clrt.scene.scene import Scene, edited

Values = dict[str, Any]
FEW: Final = 500  # up to so many pictures all are looked at, and not only each value
Known = tuple[Scene, FlatScene]


def check_series(
    scene: Scene,
    series: Sequence[Values],
    asked: Request,
    settings: Settings,
    said: Callable[[list[str], int], str],
    known: Known | None = None,
) -> set[tuple[int, int]]:
    """Width and height, in pixels, of the pictures that were looked at: each that there is.

    Raises what a picture of the series would, with the places whose values are the reason, as `said` names
    them in the picture of that number; what none of them is the reason of is raised as it is. asked: what
    holds for all. known: a scene like these, and what it was flattened to. Nobody is warned: that comes with
    the pictures.
    """
    looked, sizes = _Looked(scene, asked, settings, known), set[tuple[int, int]]()
    with notices.without(""):
        for index, values in _worth_looking(series):
            try:
                sizes.add(looked.at(values))
            except ClrtError as error:
                places = looked.reasons(values, series[0] if index else {}, error)
                if not places:
                    raise
                raise error.reworded(f"{said(places, index)}: {error}") from None
    return sizes


def _worth_looking(series: Sequence[Values]) -> Iterator[tuple[int, Values]]:
    """The pictures that are looked at, and their numbers: of many the first that has each value."""
    seen: set[tuple[str, int]] = set()
    for index, values in enumerate(series):
        own = {(place, id(value)) for place, value in values.items()}
        if len(series) <= FEW or not own <= seen:
            yield index, values
        seen |= own


class _Looked:
    """Looks at one picture after the other; what scenes share is flattened once."""

    def __init__(self, scene: Scene, asked: Request, settings: Settings, known: Known | None) -> None:
        self._scene, self._asked, self._settings, self._known = scene, asked, settings, known

    def at(self, values: Values) -> tuple[int, int]:
        """Width and height of the picture for these values. Raises what `Tracer.update` and `Tracer.render`
        would, but what a device says."""
        scene = edited(self._scene, values)
        limits = self._settings.limits
        limits.check("device_bytes", tree.least_bytes(scene), scene.source, "shapes")
        check_uneven(scene)
        flat = flatten(scene, self._known)
        check_ceilings(flat, scene.source)
        self._known = scene, flat
        _, _, (_, _, width, height) = self._asked.job(scene, flat, self._settings)
        return width, height

    def reasons(self, values: Values, right: Mapping[str, Any], error: ClrtError) -> list[str]:
        """The places whose values are the reason of an error: those that alone are, beside values that are
        `right`, else all that differ from these; none where there is the same error without any of them."""
        if self._error(dict(right)) == str(error):
            return []
        others = [place for place, value in values.items() if place not in right or right[place] is not value]
        alone = [place for place in others if self._error({**right, place: values[place]})]
        return alone or others

    def _error(self, values: Values) -> str:
        try:
            self.at(values)
        except ClrtError as error:
            return str(error)
        return ""
