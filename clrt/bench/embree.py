"""The yardstick: Embree, on the same geometry and the same rays, on one thread.

A small C++ file in the repository's tests/embree, built on request against Debian's libembree-dev (3.13), and
against the Embree 4 in the wheel of embreex where that is installed. It is a means of measuring, not a part
of clrt.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from clrt.base.errors import ClrtError
from clrt.bench.timing import Case
from clrt.flatten.flatten import FlatScene

_SOURCE: Final = Path(__file__).resolve().parents[2] / "tests" / "embree" / "yardstick.cpp"
_HEADERS: Final = Path("/usr/include/embree3")
_FLAGS: Final = ("-O3", "-march=native", "-shared", "-fPIC")
MODES: Final = ("default", "robust")
# width of the call, and whether Embree is told that the rays are coherent: which is best depends on the rays
CALLS: Final = ((1, False), (8, False), (8, True), (16, False), (16, True))


@dataclass(frozen=True)
class Build:
    """The yardstick compiled against one Embree. version: "3.13"; isa: the most it may use, "" for all."""

    library: ctypes.CDLL
    version: str
    isa: str = ""

    @property
    def tag(self) -> str:
        """What its cases are told by: nothing for Embree 3, which came first."""
        return "" if self.version.startswith("3.") else f", {self.version}"


def builds(isa: str = "") -> tuple[Build, ...]:
    """The yardstick against each Embree that is here: Debian's, and the one in embreex's wheel.

    Compiled unless it is. isa: the most that Embree may use of the processor, as `rtcNewDevice` takes it
    ("avx2"). ClrtError says what is missing where there is none.
    """
    if not _SOURCE.is_file():
        raise ClrtError(
            f"{_SOURCE}: the yardstick is only in a checkout of the repository, not in an installed clrt"
        )
    wheel = _wheel()
    found = []
    if wheel is None or _HEADERS.is_dir():
        found.append(_compiled("yardstick.so", ("-lembree3",)))
    if wheel is not None:
        place = (str(wheel), f"-Wl,-rpath,{wheel.parent}")
        found.append(_compiled("yardstick4.so", ("-DEMBREE4", *place)))
    return tuple(Build(library, _version(library), isa) for library in found)


def _wheel() -> Path | None:
    """The library of Embree 4 that embreex brings; None where that is not installed."""
    try:
        files = importlib.metadata.files("embreex") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    found = (Path(str(file.locate())).resolve() for file in files if file.name.startswith("libembree4"))
    return next((file for file in found if file.is_file()), None)


def _compiled(name: str, flags: tuple[str, ...]) -> ctypes.CDLL:
    library = _SOURCE.parents[2] / "build" / name
    newest = max(file.stat().st_mtime for file in _SOURCE.parent.iterdir())
    if not library.exists() or library.stat().st_mtime < newest:
        library.parent.mkdir(exist_ok=True)
        command = ["g++", *_FLAGS, str(_SOURCE), "-o", str(library), *flags]
        try:
            done = subprocess.run(command, capture_output=True, text=True)
        except FileNotFoundError:
            raise ClrtError("g++ is not here; the yardstick needs it (Debian: apt-get install g++)") from None
        if done.returncode:
            wanted = "Debian: apt-get install libembree-dev" if "embree3/" in done.stderr else done.stderr
            raise ClrtError(f"{_SOURCE.name} does not compile; it needs Embree 3 ({wanted})")
    loaded = ctypes.CDLL(str(library))
    for made in ("yardstick_triangles", "yardstick_spheres"):
        getattr(loaded, made).restype = ctypes.c_void_p
    loaded.yardstick_commit_seconds.restype = ctypes.c_double
    return loaded


def _version(library: ctypes.CDLL) -> str:
    number = int(library.yardstick_version())
    return f"{number // 10000}.{number // 100 % 100}"


@dataclass
class Yardstick:
    """Embree's tree over a flattened scene of only triangles or only spheres; freed by `close`."""

    build: Build
    handle: ctypes.c_void_p
    mode: str
    seconds: float  # that Embree took for its tree

    def close(self) -> None:
        self.build.library.yardstick_free(self.handle)

    def trace(
        self, rays: np.ndarray, width: int, coherent: bool, occlusion: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distances and primitive numbers (-1: a miss) of rays (7, n) float32; see `yardstick_trace`."""
        n = rays.shape[1]
        t, primitive = np.empty(n, np.float32), np.empty(n, np.int32)
        self.build.library.yardstick_trace(
            self.handle, width, occlusion, coherent, n, _pointer(rays), _pointer(t), _pointer(primitive)
        )
        return t, primitive


@dataclass(frozen=True)
class Geometry:
    """What Embree takes: vertices (n, 3) float32 and faces (m, 3) uint32, or spheres (n, 4) float32."""

    arrays: tuple[np.ndarray, ...]

    @property
    def primitives(self) -> int:
        return len(self.arrays[-1])


def geometry(flat: FlatScene) -> Geometry:
    """Of a scene of only triangles or only spheres; ClrtError for any other."""
    count = int(flat.scene["primitives"][0])
    if count == len(flat.triangles):
        corners = np.stack([flat.triangles[name][:, :3] for name in ("v0", "v1", "v2")], axis=1)
        # as rows of bytes: sorting those is ten times as fast as sorting rows of numbers
        rows = np.ascontiguousarray(corners.reshape(-1, 3)).view("V12").reshape(-1)
        _, first, faces = np.unique(rows, return_index=True, return_inverse=True)
        vertices = np.ascontiguousarray(corners.reshape(-1, 3)[first])
        return Geometry((vertices, faces.reshape(-1, 3).astype(np.uint32)))
    if count == len(flat.spheres):
        return Geometry((np.ascontiguousarray(flat.spheres["center_radius"]),))
    raise ClrtError("the yardstick takes scenes of only triangles or only spheres")


def commit(build: Build, shape: Geometry, mode: str, threads: int = 1) -> Yardstick:
    """Build Embree's tree with that many threads."""
    config = f"threads={threads}" + (f",isa={build.isa}" if build.isa else "")
    library, robust = build.library, int(mode == "robust")
    build_it = library.yardstick_triangles if len(shape.arrays) == 2 else library.yardstick_spheres
    arguments = [item for array in shape.arrays for item in (len(array), _pointer(array))]
    handle = ctypes.c_void_p(build_it(*arguments, config.encode(), robust))
    return Yardstick(build, handle, mode, float(library.yardstick_commit_seconds(handle)))


def tracing_cases(yardsticks: list[Yardstick], rays: dict[str, np.ndarray], scene: str) -> list[Case]:
    """Every call and mode on every kind of rays (kind -> (7, n) float32); shadow feelers ask for any hit."""

    def make(yardstick: Yardstick, kind: str, width: int, coherent: bool) -> Case:
        def run() -> None:
            yardstick.trace(rays[kind], width, coherent, kind == "shadow")

        return Case(
            group="embree",
            scene=scene,
            name=f"{yardstick.mode} {width}{' coherent' if coherent else ''}{yardstick.build.tag}",
            queue=kind,
            run=run,
            items=rays[kind].shape[1],
            unit="rays",
        )

    return [make(y, kind, *call) for kind in rays for y in yardsticks for call in CALLS]


def commit_cases(build: Build, shape: Geometry, scene: str, threads: int) -> list[Case]:
    """Embree's own time for its tree, in both modes."""

    def make(mode: str) -> Case:
        def run() -> float:
            made = commit(build, shape, mode, threads)
            made.close()
            return made.seconds

        return Case(
            group="embree",
            scene=scene,
            name=f"{mode} tree{build.tag}",
            run=run,
            threads=threads,
            items=shape.primitives,
            unit="primitives",
            clock="wall",
        )

    return [make(mode) for mode in MODES]


def disagreement(yardstick: Yardstick, rays: np.ndarray, ours: np.ndarray, occlusion: bool) -> float:
    """The share of rays that hit for one and miss for the other; `ours` are primitives, -1 on a miss."""
    _, theirs = yardstick.trace(rays, 1, False, occlusion)
    return float(((ours < 0) != (theirs < 0)).mean())


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)
