"""The indices around glass: each boundary of Mitsuba's has its own, a scene has solids that lie in others."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import pytest

from tests.mitsuba_samples import lost, read

NESTED = "that glass within glass has another ext_ior than the int_ior around it"
OTHER = "more than one ext_ior"
TETRAHEDRON = "v -4 -4 -4\nv 12 -4 -4\nv -4 12 -4\nv -4 -4 12\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def glass(
    size: float, inside: float, outside: float | None = None, x: float = 0.0, kind: str = "sphere",
    z: float = 0.0,
) -> str:
    """A sphere, a cube or a pane of that half size, or as many times the tetrahedron or a tube."""
    indices = f'<float name="int_ior" value="{inside}"/>'
    indices += "" if outside is None else f'<float name="ext_ior" value="{outside}"/>'
    bsdf = f'<bsdf type="{"thin" if kind == "rectangle" else ""}dielectric">{indices}</bsdf>'
    steps = f'<scale value="{size}"/><translate x="{x}" z="{z}"/>'
    file = '<string name="filename" value="a.obj"/>' if kind == "obj" else ""
    return f'<shape type="{kind}">{file}<transform name="to_world">{steps}</transform>{bsdf}</shape>'


def cube(size: float, inside: float, outside: float | None = None) -> str:
    return glass(size, inside, outside, kind="cube")


def pane(size: float, inside: float, outside: float | None = None) -> str:
    return glass(size, inside, outside, kind="rectangle")


def mesh(size: float, inside: float, outside: float | None = None) -> str:
    return glass(size, inside, outside, kind="obj")


def tube(size: float, inside: float, outside: float | None = None) -> str:
    return glass(size, inside, outside, kind="cylinder")


def plate(size: float, inside: float, outside: float | None = None) -> str:
    return glass(size, inside, outside, kind="disk")


TILTED = '<transform name="to_world"><rotate x="1" angle="40"/></transform>'
SHEET = f'<shape type="rectangle">{TILTED}<bsdf type="dielectric"/></shape>'  # a box, and nothing within it


@pytest.mark.parametrize("turn", [1, -1])
@pytest.mark.parametrize(
    ("shapes", "medium", "named"),
    [
        ([glass(1, 1.33, 1.0), glass(0.6, 1.0, 1.33)], 1.0, ""),
        ([glass(1, 1.5), glass(0.5, 1.4)], 1.0, NESTED), ([glass(1, 1.5), glass(0.5, 1.5)], 1.0, NESTED),
        ([glass(1, 1.5), glass(0.5, 1.4, x=3)], 1.0, ""),
        ([cube(2, 1.5), glass(0.5, 1.4)], 1.0, NESTED), ([cube(2, 1.5), glass(0.5, 1.4, 1.5)], 1.0, ""),
        ([mesh(1, 1.5), glass(0.5, 1.4)], 1.0, NESTED), ([mesh(1, 1.5), glass(0.5, 1.4, 1.5)], 1.0, ""),
        ([glass(9, 1.5), mesh(0.1, 1.4)], 1.0, NESTED), ([mesh(1, 1.5), glass(0.5, 1.4, x=8)], 1.0, ""),
        ([glass(3, 1.5), glass(2, 1.0, 1.5), glass(0.5, 1.5)], 1.0, ""),
        ([glass(9, 1.5), cube(0.5, 1.4)], 1.0, NESTED), ([tube(4, 1.5), glass(0.5, 1.4, z=2)], 1.0, ""),
        ([glass(9, 1.5), tube(1, 1.4)], 1.0, NESTED), ([glass(9, 1.5), tube(1, 1.4, 1.5)], 1.0, ""),
        ([glass(9, 1.5), plate(1, 1.4)], 1.0, NESTED), ([glass(9, 1.5), plate(1, 1.4, 1.5)], 1.0, ""),
        ([SHEET, glass(0.3, 1.4)], 1.0, ""),
        ([glass(3, 1.5), glass(2, 1.0, 1.5), glass(0.5, 1.5, 1.5)], 1.0, NESTED),
        ([glass(1, 1.33), pane(0.3, 1.5)], 1.0, NESTED), ([glass(1, 1.33), pane(0.3, 1.5, 1.33)], 1.0, ""),
        ([glass(1, 1.5, 1.33), glass(1, 1.4, 1.33, 3.0)], 1.33, ""),
        ([glass(1, 1.5, 1.33), glass(1, 1.4, 1.2, 3.0)], 1.2, OTHER),
    ],
)  # fmt: skip
def test_boundaries_of_glass_in_glass(
    tmp_path: Path, shapes: list[str], medium: float, named: str, turn: int
) -> None:
    """In Mitsuba each has two indices of its own; here those of the solids that meet, in any order."""
    (tmp_path / "a.obj").write_text(TETRAHEDRON)
    body = "".join(shapes[::turn])
    if named:
        assert lost(tmp_path, body) == named
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if named else "error")
        warnings.filterwarnings("ignore", ".*transmits but encloses nothing")
        assert read(tmp_path, body).medium_ior == medium


def test_of_more_than_can_be_looked_at_nobody_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = glass(2, 1.5) + glass(0.5, 1.4)
    assert lost(tmp_path, body) == NESTED
    monkeypatch.setattr("clrt.formats.mitsuba.surroundings._WORK", 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(tmp_path, body)


def test_shapes_of_one_material(tmp_path: Path) -> None:
    one = '<bsdf type="dielectric" id="a"><float name="int_ior" value="1.4"/></bsdf>'
    balls = "".join(glass(1, 1.5, x=3 * k).partition("<bsdf")[0] + '<ref id="a"/></shape>' for k in range(3))
    scene = read(tmp_path, one + balls)
    assert [scene.material_of(shape).ior for shape in scene.shapes] == [1.4] * 3 and len(scene.materials) == 1


@pytest.mark.parametrize("nested", [False, True])
def test_many_solids_are_looked_through_in_time(tmp_path: Path, nested: bool) -> None:
    took = []
    for count in (1000, 4000):
        places = [(1 + k / count, 0.0) if nested else (0.4, float(k)) for k in range(count)]
        body = "".join(glass(size, 1.0, 1.0, x) for size, x in places)
        began = time.process_time()
        read(tmp_path, body)
        took.append(time.process_time() - began)
    assert took[1] <= 6 * took[0]
