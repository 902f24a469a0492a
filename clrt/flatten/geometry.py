"""The sections of a world that hold its geometry, and the padded boxes that the tree is built over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from clrt import layout
from clrt.base import notices
from clrt.base.errors import SceneError, located
from clrt.flatten import mesh as flatten_mesh
from clrt.flatten import quadric as flatten_quadric
from clrt.flatten.shapes import Collected, concatenated
from clrt.scene.scene import Mesh, Scene

_CHUNK = 1 << 15  # boxes treated at once: what fits the cache
LARGEST: Final = 1e15  # |coordinate|, and 1 / it a scene's least size: float32 loses products beyond
_TRIANGLES: Final = 1e12  # the same of triangles, whose test multiplies three
_LOWEST, _HIGHEST = np.float32(-np.inf), np.float32(np.inf)


@dataclass(frozen=True)
class Boxes:
    """Boxes of all primitives of a kind: records (n,) Box, rounded outwards; infinite where there is none."""

    records: np.ndarray
    bounded: np.ndarray  # (n,) bool
    too_far: np.ndarray  # (n,) bool: beyond what kernels take

    @staticmethod
    def of(n: int) -> Boxes:
        """Room for so many."""
        return Boxes(np.zeros(n, layout.dtype("Box")), np.empty(n, bool), np.empty(n, bool))

    def put(
        self, part: slice, low: np.ndarray, high: np.ndarray, pad: float, extra: np.ndarray, largest: float
    ) -> None:
        """Boxes (3, k), computed in float64, wider by `pad` times their largest |coordinate| and by `extra`.

        largest: |coordinate| that kernels take.
        Of few at a time, which stay in a processor's cache, and axis by axis: numpy is slow on rows of 3.
        """
        least, most = low.astype(np.float64), high.astype(np.float64)
        margin = pad * _farthest(least, most) + extra
        least, most = least - margin, most + margin
        least32, most32 = least.astype(np.float32), most.astype(np.float32)
        least32 = np.where(least32 > least, np.nextafter(least32, _LOWEST), least32)
        most32 = np.where(most32 < most, np.nextafter(most32, _HIGHEST), most32)
        extent = np.isfinite(most32 * 0.5 - least32 * 0.5)
        for axis in range(3):
            self.records["low"][part, axis], self.records["high"][part, axis] = least32[axis], most32[axis]
        self.bounded[part] = extent.all(axis=0)
        self.too_far[part] = ~(_farthest(least32, most32) <= largest)


GEOMETRY: Final = (
    "primitives", *layout.SECTIONS.values(), "normals", "vertices", "unbounded", "boxes", "finite"
)  # fmt: skip
"""What `geometry` gives."""


def geometry(collected: Collected, scene: Scene) -> dict[str, np.ndarray]:
    """All sections from `primitives` to `unbounded`, and `boxes` and `finite` as FlatScene has them.

    Raises `SceneError` where coordinates leave the range of float32 or a shape shrinks to nothing in it.
    """
    primitives = collected.primitives()
    sections: dict[str, np.ndarray] = {"primitives": primitives}
    boxes: dict[str, Boxes] = {}
    sections["spheres"], boxes["SPHERE"] = _spheres(collected)
    sections["planes"], boxes["PLANE"] = _planes(collected)
    sections["disks"], boxes["DISK"] = _disks(collected)
    sections["triangles"], boxes["TRIANGLE"] = _triangles(collected)
    sections["normals"] = concatenated(collected.corner_normals, np.zeros((0, 4), np.float32))
    sections["polygons"], sections["vertices"], boxes["POLYGON"] = _polygons(collected)
    sections["quadrics"], boxes["QUADRIC"], thin = _quadrics(collected)
    _check_kinds(collected, sections, boxes)
    _check(scene, sections, boxes)
    _refuse(scene, sections, "QUADRIC", thin, _THIN)
    _gather(sections, boxes)
    _warn_of_smallness(scene, sections)
    return sections


def _check_kinds(collected: Collected, sections: dict[str, np.ndarray], boxes: dict[str, Boxes]) -> None:
    """Every primitive has a record and a box: the kernels look neither up with care."""
    for kind, section in layout.SECTIONS.items():
        found = {len(sections[section]), len(boxes[kind].records)}
        if found != {collected.counts[kind]}:
            raise AssertionError(f"{collected.counts[kind]} primitives {kind}, but {found} records and boxes")
    if sum(collected.counts.values()) != len(sections["primitives"]):
        raise AssertionError("primitives of a kind that is not in layout.SECTIONS")


def padded(low: np.ndarray, high: np.ndarray, pad: float, extra: np.ndarray | float = 0.0) -> Boxes:
    """Boxes (n, 3), wider by `pad` times their largest |coordinate| and by `extra`."""
    out, extra = Boxes.of(len(low)), np.broadcast_to(extra, len(low))
    for part in _parts(len(low)):
        # in C's order, which sums and products of it keep
        out.put(part, low[part].T.copy(), high[part].T.copy(), pad, extra[part], LARGEST)
    return out


def _parts(n: int) -> Iterator[slice]:
    return (slice(start, min(start + _CHUNK, n)) for start in range(0, n, _CHUNK))


def _farthest(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The largest |coordinate| of each of the boxes (3, k)."""
    return np.asarray(np.maximum(-low, high).max(axis=0))


def _spheres(collected: Collected) -> tuple[np.ndarray, Boxes]:
    out = np.zeros(len(collected.spheres), layout.dtype("Sphere"))
    out["center_radius"] = np.reshape(collected.spheres, (-1, 4))
    center, radius = np.split(out["center_radius"].astype(np.float64), [3], axis=1)
    return out, padded(center - radius, center + radius, layout.PAD)


def _planes(collected: Collected) -> tuple[np.ndarray, Boxes]:
    out = np.zeros(len(collected.planes), layout.dtype("Plane"))
    rows = np.reshape(collected.planes, (-1, 6))
    out["point"][:, :3], out["normal"][:, :3] = rows[:, :3], rows[:, 3:]
    everywhere = np.full((len(out), 3), np.inf, np.float32)
    return out, padded(-everywhere, everywhere, 0.0)


def _disks(collected: Collected) -> tuple[np.ndarray, Boxes]:
    out = np.zeros(len(collected.disks), layout.dtype("Disk"))
    rows = np.reshape(collected.disks, (-1, 7))
    out["center_radius"], out["normal"][:, :3] = rows[:, :4], rows[:, 4:]
    center, radius = np.split(out["center_radius"].astype(np.float64), [3], axis=1)
    square = np.square(out["normal"][:, :3].astype(np.float64))
    half = radius * np.sqrt(
        square[:, [1, 2, 0]] + square[:, [2, 0, 1]]
    )  # sqrt(1 - n_i^2) without cancellation
    return out, padded(center - half, center + half, layout.PAD)


def _triangles(collected: Collected) -> tuple[np.ndarray, Boxes]:
    out = concatenated(collected.triangles, np.zeros(0, layout.dtype("Triangle")))
    boxes, nothing = Boxes.of(len(out)), np.zeros(1)
    for part in _parts(len(out)):
        boxes.put(part, *flatten_mesh.triangle_boxes(out[part]), layout.PAD, nothing, _TRIANGLES)
    return out, boxes


def _polygons(collected: Collected) -> tuple[np.ndarray, np.ndarray, Boxes]:
    out, vertices, low, high, off = flatten_mesh.polygons(collected.corners, collected.corner_counts)
    return out, vertices, padded(low, high, layout.PAD, 2 * off)


def _quadrics(collected: Collected) -> tuple[np.ndarray, Boxes, np.ndarray]:
    out, low, high, thin = flatten_quadric.records(collected.forms)
    return out, padded(low, high, layout.QUADRIC_PAD), thin


_THIN: Final = (
    "it is less than 1e-7 of its length thick, or tapers by less, which is lost in rounding; make it "
    "thicker, or use a disk, a polygon or a cylinder"
)


def _too_large(largest: float) -> str:
    return f"its coordinates are beyond {largest:g}, whose products float32 cannot hold; make it smaller"


def _check(scene: Scene, sections: dict[str, np.ndarray], boxes: dict[str, Boxes]) -> None:
    """Raise for the first shape that float32 cannot hold."""
    for kind in ("SPHERE", "DISK", "TRIANGLE", "POLYGON"):
        most = _TRIANGLES if kind == "TRIANGLE" else LARGEST
        _refuse(scene, sections, kind, boxes[kind].too_far, _too_large(most))
    far = (np.abs(sections["planes"]["point"]) > LARGEST).any(axis=1)  # a plane's box is endless
    _refuse(scene, sections, "PLANE", far, _too_large(LARGEST))
    quadrics = sections["quadrics"]
    axes = ("axis_x", "axis_y", "axis_z")
    held = [np.isfinite(quadrics[name]).all(axis=1) for name in (*axes, "form")]
    held += [(np.abs(quadrics[name][:, :3]) <= LARGEST).all(axis=1) for name in ("center", "reach")]
    solid = (quadrics["form"][:, :3] != 0).any(1) | np.any([quadrics[name][:, 3] for name in axes], axis=0)
    _refuse(scene, sections, "QUADRIC", ~np.all(held, axis=0), _too_large(LARGEST))
    _refuse(scene, sections, "QUADRIC", ~solid, "its form vanishes in float32; make it larger or smaller")
    for kind, section in (("SPHERE", "spheres"), ("DISK", "disks")):
        _refuse(
            scene,
            sections,
            kind,
            sections[section]["center_radius"][:, 3] == 0,
            "its radius vanishes in float32",
        )
    empty = ~(sections["polygons"]["normal"][:, :3] != 0).any(axis=1)
    right = "it spans no area in float32; make it larger or move it towards the origin"
    _refuse(scene, sections, "POLYGON", empty, right, meshes=False)  # a face without area is just never hit


def _refuse(
    scene: Scene, sections: dict[str, np.ndarray], kind: str, bad: np.ndarray, text: str, meshes: bool = True
) -> None:
    """`bad` tells of each primitive of a kind whether it is at fault."""
    if not bad.any():
        return
    primitives = sections["primitives"]
    shapes = primitives["shape"][primitives["kind"] == layout.KINDS[kind]]
    for shape in np.unique(shapes[bad]):
        if meshes or not isinstance(scene.shapes[shape], Mesh):
            raise SceneError(located(scene.source, f"shapes[{shape}]", text))


def _warn_of_smallness(scene: Scene, sections: dict[str, np.ndarray]) -> None:
    """Warn of a scene that float32 takes for a point: no ray would meet anything in it."""
    boxes = sections["boxes"]
    if len(boxes) == 0 or len(sections["unbounded"]):
        return
    if (boxes["high"][0] - boxes["low"][0]).max() >= 1 / LARGEST:  # of most scenes
        return
    size = float((boxes["high"] - boxes["low"])[:, :3].max())
    if size < 1 / LARGEST:
        text = f"all shapes are below {1 / LARGEST:g}, whose products float32 loses; scale the scene up"
        notices.warn(scene.source, "shapes", text)


def _gather(sections: dict[str, np.ndarray], boxes: dict[str, Boxes]) -> None:
    """Add `unbounded`, `finite` and `boxes`: from the order of the kinds to that of the primitives."""
    primitives = sections["primitives"]
    out, bounded = np.zeros(0, layout.dtype("Box")), np.zeros(len(primitives), bool)
    for kind, of_kind in boxes.items():
        if len(of_kind.records) == len(primitives):
            out, bounded = of_kind.records, of_kind.bounded
        elif len(of_kind.records):
            out = out if len(out) else np.zeros(len(primitives), layout.dtype("Box"))
            # a kind's primitives are numbered in the order of its section
            which = primitives["kind"] == layout.KINDS[kind]
            out[which], bounded[which] = of_kind.records, of_kind.bounded
    sections["finite"] = np.flatnonzero(bounded).astype(np.int32)
    sections["unbounded"] = np.flatnonzero(~bounded).astype(np.int32)
    sections["boxes"] = out if bounded.all() else out[bounded]
