"""Shapes that are changed by their names: in proportion to how many, and by the names that they have then."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import clrt
from clrt.scene.edit import places
from tests.growth import check_growth

SPHERE: dict[str, Any] = {"type": "sphere", "center": [0, 0, 0], "radius": 0.3}


def balls(n: int) -> list[dict[str, Any]]:
    return [{**SPHERE, "name": f"ball {i}"} for i in range(n)]


def moved(n: int) -> dict[str, Any]:
    return {f'shapes."ball {i}".center': [i, 1, 0] for i in range(n)}


CHANGES: dict[str, Callable[[int], dict[str, Any]]] = {
    "moved": moved,
    "named anew": lambda n: {f'shapes."ball {i}".name': f"{i}" for i in range(n)},
    "another": lambda n: {f'shapes."ball {i}"': {**SPHERE, "name": f"{i}"} for i in range(n)},
    "of new ones": lambda n: {"shapes": balls(n), **moved(n)},
}


@pytest.mark.parametrize("name", CHANGES)
def test_many_by_name(name: str) -> None:
    def make(n: int) -> Callable[[], object]:
        return partial(clrt.load_dict({"shapes": balls(n)}).replace, CHANGES[name](n))

    check_growth(make, 1000)


def test_many_places() -> None:
    check_growth(lambda n: partial(places, clrt.load_dict({"shapes": balls(n)}), moved(n)), 1000)


@given(
    names=st.lists(st.sampled_from([None, "a", "b", "c"]), min_size=1, max_size=6),
    steps=st.lists(
        st.tuples(st.sampled_from([*range(6), *"abcd"]), st.sampled_from([None, "a", "b", "c", "d"])),
        unique_by=lambda step: step[0],
    ),
    whole=st.booleans(),
)
def test_names_are_those_of_the_changes_before(names: Any, steps: Any, whole: bool) -> None:
    """Which may repeat: of two of one name it is said that they are."""
    shapes = [{**SPHERE, "name": name} if name else SPHERE for name in names]
    scene = clrt.load_dict({"shapes": [SPHERE] if whole else shapes})
    changes: dict[str, Any] = {"shapes": shapes} if whole else {}
    error = ""
    for place, name in steps:
        if isinstance(place, int):
            changes[f"shapes[{place}].name"] = name
            error = error or ("" if place < len(names) else f"there is no number {place}")
            number = place
        else:
            changes[f"shapes.{place}.name"] = name
            count = names.count(place)
            error = error or ("" if count == 1 else f"{count} shapes have" if count else "no shape has")
            number = 0 if error else names.index(place)
        if error:
            with pytest.raises(clrt.SceneError, match=error):
                scene.replace(changes)
            return
        names[number] = name
    assert [shape.name for shape in scene.replace(changes).shapes] == names
