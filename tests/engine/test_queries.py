"""Questions about rays: any shape and kind of array, any choice of fields, the same bits."""

from __future__ import annotations

import copy
import pickle
import threading
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.engine.answers import FIELDS
from clrt.engine.batch import Batch, row_length

MESH = {
    "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}
SCENE: dict[str, Any] = {
    "ambient": 0.1,
    "shapes": [
        {"type": "sphere", "center": [-1, 0, 0], "radius": 0.7},
        {"type": "mesh", **MESH},
        {"type": "mesh", **MESH, "smooth": True, "transform": [{"translate": [0.4, 0.3, -0.2]}]},
        {"type": "box", "min": [-2, -2, -1], "max": [0, -1, 1]},
        {"type": "cylinder", "p0": [1, -1, -1], "p1": [1, -1, 1], "radius": 0.4, "caps": True},
        {"type": "plane", "point": [0, -3, 0], "normal": [0, 1, 0]},
    ],
}


@pytest.fixture(scope="module")
def tracer() -> clrt.Tracer:
    return clrt.Tracer(SCENE)


def rays(*lead: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """float32, towards the scene from all around, some of which miss, and some that no ray can be."""
    rng = np.random.default_rng(seed)
    origins = rng.normal(size=(*lead, 3)).astype(np.float32) * 3
    directions = (rng.normal(size=(*lead, 3)) - origins).astype(np.float32)
    flat = directions.reshape(-1, 3)
    flat[::53] = 0
    flat[7::53] = np.nan
    origins.reshape(-1, 3)[11::53, 1] = np.inf
    return origins, directions


def values(hits: Any) -> dict[str, np.ndarray]:
    return {name: getattr(hits, name) for name in FIELDS}


def same(found: Any, expected: Any, names: Any = FIELDS) -> bool:
    return all(getattr(found, n).tobytes() == getattr(expected, n).tobytes() for n in names)


def test_only_the_fields_that_are_asked_for_with_the_same_bits(tracer: clrt.Tracer) -> None:
    o, d = rays(2000)
    every = tracer.intersect(o, d)
    assert {a.dtype.name for a in values(every).values()} == {"float32", "int32"}
    met = every.primitive >= 0
    assert 500 < np.count_nonzero(met) < 1900 and len(np.unique(every.shape)) == 7
    assert np.isinf(every.t[~met]).all() and (every.shape[~met] == -1).all()
    assert not every.normal[~met].any() and np.allclose(np.linalg.norm(every.normal[met], axis=1), 1)
    for names in (["t"], ["primitive"], ("t", "primitive"), {"shape"}, ["normal"], ["v", "u"], ["u", "t"]):
        hits = tracer.intersect(o, d, fields=names)
        assert same(hits, every, names)
        missing = next(name for name in FIELDS if name not in names)
        with pytest.raises(clrt.ClrtError, match=f"{missing}: was not asked for; add '{missing}' to fields="):
            getattr(hits, missing)
        assert not hasattr(hits, missing) and f"{missing}=array" not in repr(hits)
    with pytest.raises(AttributeError):
        every.nothing  # noqa: B018
    for copied in (copy.copy(every), pickle.loads(pickle.dumps(every))):
        assert same(copied, every)


def test_only_what_is_asked_for_is_computed(tracer: clrt.Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    launched: list[str] = []
    kind = type(tracer.device)
    launch = kind.launch

    def noted(self: Any, name: str, *rest: Any, **named: Any) -> None:
        launched.append(name)
        launch(self, name, *rest, **named)

    monkeypatch.setattr(kind, "launch", noted)
    o, d = rays(64)
    tracer.intersect(o, d, fields=["t", "primitive"])
    assert launched == ["nearest"]
    launched.clear()
    tracer.intersect(o, d)
    tracer.occluded(o, d)
    assert launched == ["nearest", "met", "blocked"]


def strange(array: np.ndarray) -> dict[str, np.ndarray]:
    """The same numbers in other memory."""
    apart = np.zeros((2 * array.shape[0], *array.shape[1:-1], 5), array.dtype)
    apart[::2, ..., 1:4] = array
    shifted = np.frombuffer(b"\0" + array.tobytes(), np.uint8)[1:].view(array.dtype).reshape(array.shape)
    fixed = array.copy()
    fixed.flags.writeable = False
    return {
        "float64": array.astype(np.float64), "long double": array.astype(np.longdouble),
        "other byte order": array.astype(array.dtype.newbyteorder()), "in columns": np.asfortranarray(array),
        "apart": apart[::2, ..., 1:4], "backwards": array[::-1].copy()[::-1], "not aligned": shifted,
        "read-only": fixed, "a list": array.tolist(),
    }  # fmt: skip


@pytest.mark.parametrize("lead", [(), (1,), (37,), (5, 7), (8, 12), (3, 2, 6)], ids=str)
def test_any_shape_and_any_kind_of_array(tracer: clrt.Tracer, lead: tuple[int, ...]) -> None:
    o, d = rays(*lead, seed=5)
    flat = tracer.intersect(o.reshape(-1, 3), d.reshape(-1, 3))
    dark = tracer.occluded(o.reshape(-1, 3), d.reshape(-1, 3))
    counts = tracer.count_hits(o.reshape(-1, 3), d.reshape(-1, 3))
    found = tracer.intersect(o, d)
    assert same(found, flat) and found.t.shape == lead and found.normal.shape == (*lead, 3)
    if not lead:
        return
    others = zip(strange(o).items(), strange(d).values(), strict=True)
    for (name, origins), directions in others:
        assert same(tracer.intersect(origins, directions), flat), name
        assert np.array_equal(tracer.occluded(origins, directions), dark.reshape(lead)), name
    assert np.array_equal(tracer.count_hits(strange(o)["float64"], d), counts.reshape(lead))
    whole = tracer.intersect(np.zeros((*lead, 3), np.int8), np.ones((*lead, 3), np.int64))
    assert np.isfinite(whole.t).all()


def test_arrays_are_broadcast(tracer: clrt.Tracer) -> None:
    o, d = rays(6, 8)
    d[~np.isfinite(d)] = 1
    from_one = tracer.intersect(o[1, 1], d)
    assert same(from_one, tracer.intersect(np.broadcast_to(o[1, 1], d.shape).copy(), d))
    assert same(tracer.intersect(o, [0, -1, 0]), tracer.intersect(o, np.tile([0.0, -1.0, 0.0], (6, 8, 1))))
    rows, columns = tracer.intersect(o[:, :1], d[:1]), np.broadcast_arrays(o[:, :1], d[:1])
    assert rows.t.shape == (6, 8) and same(rows, tracer.intersect(*map(np.array, columns)))
    far = np.linspace(0, 9, 8, dtype=np.float32)
    limits = np.array(np.broadcast_to(far, (6, 8)))
    for keys in ({"t_max": far}, {"t_min": far}, {"t_min": far[::-1], "t_max": 6}):
        full = {name: np.array(np.broadcast_to(v, (6, 8)), np.float64) for name, v in keys.items()}
        assert same(tracer.intersect(o, d, **keys), tracer.intersect(o, d, **full))
        assert np.array_equal(tracer.occluded(o, d, **keys), tracer.occluded(o, d, **full))
        assert np.array_equal(tracer.count_hits(o, d, **keys), tracer.count_hits(o, d, **full))
    assert tracer.occluded(o, d, t_max=limits).any() and not tracer.occluded(o, d, t_max=limits).all()


def test_one_ray_may_have_many_bounds(tracer: clrt.Tracer) -> None:
    o, d = [-5.0, 0.01, 0.02], [1.0, 0, 0]
    every = tracer.all_hits(o, d).t
    ends = np.array([0.0, *every, np.inf], np.float32)
    assert len(every) > 2 and tracer.intersect(o, d, t_min=ends[:-1]).t.tolist() == ends[1:].tolist()
    table = tracer.count_hits(o, d, t_min=ends[:, None], t_max=ends)
    assert table.shape == (len(ends), len(ends))
    between = [[((every > a) & (every < b)).sum() for b in ends] for a in ends]
    assert np.array_equal(table, between)
    rows = tracer.occluded([o, [0, 50, 0]], d, t_max=[[1.0], [100.0]])
    assert rows.tolist() == [[False, False], [True, False]]


def test_light_along_rays_of_any_shape(tracer: clrt.Tracer) -> None:
    o, d = tracer.camera_rays({"origin": [1, 2, 5], "target": [0, 0, 0], "width": 12, "height": 9})
    light, counts = tracer.radiance(o, d)
    flat, same_counts = tracer.radiance(o.reshape(-1, 3), d.reshape(-1, 3))
    assert light.shape == (9, 12, 3) and light.tobytes() == flat.tobytes() and counts == same_counts
    assert tracer.radiance(o[0, 0], d[4])[0].tobytes() == light[4].tobytes()
    assert tracer.radiance(o[0, 0], d[4, 5])[0].tolist() == light[4, 5].tolist()
    assert tracer.radiance(o[:, :0], d[0, 0])[0].shape == (9, 0, 3)


def test_patches_of_pictures_and_tiles_change_no_bit(tracer: clrt.Tracer) -> None:
    camera = clrt.Camera(origin=[1, 2, 5], target=[0, 0, 0], width=64, height=43)
    o, d = tracer.camera_rays(camera)
    flat = tracer.intersect(o.reshape(-1, 3), d.reshape(-1, 3))
    assert Batch(o, d, 0, np.inf).width == 64 and Batch(o.reshape(-1, 3), d[0, 0], 0, np.inf).width == 0
    assert same(tracer.intersect(o, d), flat) and same(tracer.intersect(o[0, 0], d), flat)
    for settings in (clrt.Settings(tile=100), clrt.Settings(lanes=8), clrt.Settings(local_size=16, tile=300)):
        other = clrt.Tracer(SCENE, settings=settings)
        assert same(other.intersect(o, d), flat)
        assert np.array_equal(other.occluded(o, d).ravel(), flat.primitive >= 0)
        crossings, expected = other.all_hits(o, d), tracer.all_hits(o, d)
        assert same(crossings, expected) and np.array_equal(crossings.splits, expected.splits)


def test_the_rows_of_a_flat_picture_are_found(tracer: clrt.Tracer) -> None:
    for size in ((320, 240), (1024, 64)):
        camera = clrt.Camera(origin=[1, 2, 5], target=[0, 0, 0], width=size[0], height=size[1])
        o, d = (array.reshape(-1, 3) for array in tracer.camera_rays(camera))
        assert Batch(o, d, 0, np.inf).width == size[0]
        part = tracer.intersect(o[:999], d[:999])
        assert part.t.tobytes() == tracer.intersect(o, d).t[:999].tobytes()
    o, d = rays(70000)
    assert Batch(o, d, 0, np.inf).width % 4 == 0  # whatever is taken for rows
    assert row_length(np.zeros((9, 3))) == 0 and row_length(np.full((9, 3), np.nan)) == 0


def test_bounds(tracer: clrt.Tracer) -> None:
    """What lies beyond `t_min` is the first of all crossings that do, also a sphere's far side."""
    o, d = rays(3000, seed=9)
    crossings = tracer.all_hits(o, d)
    rng = np.random.default_rng(2)
    least = rng.uniform(-1, 6, len(o)).astype(np.float32)
    most = rng.uniform(0, 9, len(o)).astype(np.float32)
    near, far = tracer.intersect(o, d, t_min=least), tracer.intersect(o, d, t_min=least, t_max=most)
    seen = tracer.occluded(o, d, t_min=least, t_max=most)
    counts = tracer.count_hits(o, d, t_min=least, t_max=most)
    for i in range(len(o)):
        part = slice(*crossings.splits[i : i + 2])
        t = crossings.t[part]
        beyond = t > least[i]
        assert near.t[i] == min(t[beyond], default=np.inf)
        within = beyond & (t < most[i])
        assert far.t[i] == min(t[within], default=np.inf)
        assert seen[i] == within.any() and counts[i] == within.sum()
    nothing = np.full(len(o), np.nan, np.float32)
    for keys in ({"t_min": nothing}, {"t_max": nothing}, {"t_min": np.nan}, {"t_min": np.inf}, {"t_max": 0}):
        assert not tracer.occluded(o, d, **keys).any() and not tracer.count_hits(o, d, **keys).any()
        assert (tracer.intersect(o, d, **keys).primitive == -1).all()


def test_crossings_are_in_order_and_say_what_they_are(tracer: clrt.Tracer) -> None:
    o, d = rays(40, 50, seed=3)
    found, nearest = tracer.all_hits(o, d), tracer.intersect(o, d)
    assert len(found) == found.splits[-1] == len(found.t) and found.splits.shape == (2001,)
    assert np.array_equal(found.counts.reshape(40, 50), tracer.count_hits(o, d))
    assert found.counts.max() >= 6
    assert np.array_equal(found.rays, np.repeat(np.arange(2000), found.counts))
    inner = np.diff(found.rays) == 0
    assert (np.diff(found.t)[inner] >= 0).all()
    met = found.counts > 0
    first = found.splits[:-1][met]
    for name in FIELDS:  # no ray runs through an edge
        assert getattr(found, name)[first].tobytes() == getattr(nearest, name).reshape(2000, *getattr(
            nearest, name).shape[2:])[met].tobytes(), name
    assert same(tracer.all_hits(o, d, fields=["shape"]), found, ["shape"])
    # through a sphere in and out
    ball = found.shape == 0
    sense = np.einsum("ij,ij->i", found.normal, d.reshape(-1, 3)[found.rays]) > 0
    out_of, into = found.rays[ball & sense], found.rays[ball & ~sense]
    within = np.linalg.norm(o.reshape(-1, 3) - (-1, 0, 0), axis=1) < 0.7
    assert len(into) > 100 and not within[into].any()
    assert np.array_equal(out_of, np.sort([*into, *out_of[within[out_of]]]))
    empty = tracer.all_hits([0, 50, 0], [0, 1, 0])
    assert len(empty) == 0 and empty.splits.tolist() == [0, 0] and empty.normal.shape == (0, 3)


def test_no_rays(tracer: clrt.Tracer) -> None:
    for lead in ((0,), (0, 4), (3, 0)):
        none = np.zeros((*lead, 3))
        assert tracer.intersect(none, none).normal.shape == (*lead, 3)
        assert tracer.occluded(none, [0, 0, 1]).shape == lead and tracer.count_hits(none, none).shape == lead
        assert tracer.all_hits(none, none).splits.tolist() == [0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda t: t.intersect([1, 2], [1, 2, 3]), r"origins: shape \(2,\) is not \(..., 3\)"),
        (lambda t: t.occluded(5, [1, 2, 3]), r"origins: shape \(\) is not \(..., 3\)"),
        (
            lambda t: t.all_hits(np.ones((2, 3)), np.ones((4, 5, 3))),
            r"shapes \(2, 3\) and \(4, 5, 3\) do not go together",
        ),
        (
            lambda t: t.count_hits(np.ones((2, 3)), np.ones(3), t_min=[1, 2, 3]),
            r"t_min: shape \(3,\) is neither a number nor \(2,\)",
        ),
        (lambda t: t.intersect(np.ones((5, 3)), np.ones(3), [1, 2]), r"t_max: shape \(2,\)"),
        (lambda t: t.intersect(np.ones(3), "up"), "directions: 'up' is not allowed"),
        (lambda t: t.intersect(np.ones(3), np.ones(3, complex)), "directions: "),
        (lambda t: t.intersect(np.ones(3), np.ones(3), fields="t"), "fields: 't' is not .* list of names"),
        (lambda t: t.intersect(np.ones(3), np.ones(3), fields=[]), r"fields: \[\] is not allowed"),
        (lambda t: t.all_hits(np.ones(3), np.ones(3), fields=["norml"]), "fields: 'norml' is none.*'normal'"),
        (lambda t: t.intersect(np.ones(3), np.ones(3), fields=[3]), "fields: "),
    ],
)
def test_what_is_wrong_is_said(tracer: clrt.Tracer, call: Callable[[clrt.Tracer], Any], words: str) -> None:
    with pytest.raises(clrt.ClrtError, match=words):
        call(tracer)


def test_memory_is_bounded_whatever_the_arrays_are(tracer: clrt.Tracer) -> None:
    """The caller's float32 arrays are read where they lie; of others a piece at a time is copied."""
    o, d = rays(400_000)
    wide = o.astype(np.float64), d[::-1].astype(np.float64)[::-1]
    tracer.intersect(o[:10], d[:10])
    for given, most in (((o, d), 2 << 20), (wide, 8 << 20)):
        tracemalloc.start()
        try:
            tracer.intersect(*given, fields=["t", "primitive"])
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < 8 * len(o) + most
    tight = clrt.Tracer(SCENE, settings=clrt.Settings(limits=clrt.Limits(host_bytes=1000)))
    assert tight.intersect(o[:125], d[:125], fields=["t", "u"]).t.shape == (125,)
    for call in (tight.intersect, tight.all_hits, tight.count_hits, tight.occluded):
        with pytest.raises(clrt.LimitError, match=r"rays: host_bytes: .* fewer rays"):
            call(o[:1001], d[:1001])


def test_threads_may_ask_at_once(tracer: clrt.Tracer) -> None:
    asked = [rays(300 + 40 * k, seed=k) for k in range(6)]
    expected = [tracer.intersect(o, d) for o, d in asked]
    found: dict[int, bool] = {}

    def ask(k: int) -> None:
        found[k] = all(same(tracer.intersect(*asked[k]), expected[k]) for _ in range(10))

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(len(asked))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == dict.fromkeys(range(6), True)


@pytest.mark.parametrize("dimensions", [40, 61])
def test_more_dimensions_than_numpy_broadcasts(tracer: clrt.Tracer, dimensions: int) -> None:
    origins = np.zeros((1,) * dimensions + (3,), np.float32)
    try:
        assert tracer.occluded(origins, [0, 0, 1]).shape == origins.shape[:-1]
    except clrt.ClrtError as error:
        assert "do not go together" in str(error)


def test_surfaces_that_cannot_be_seen_from_behind_are_not_crossed_from_there() -> None:
    made = clrt.Tracer({"one_sided": "opaque", "ambient": 0.1, "shapes": [{"type": "mesh", **MESH}]})
    both = clrt.Tracer({"ambient": 0.1, "shapes": [{"type": "mesh", **MESH}]})
    o, d = rays(500, seed=8)
    hits, seen = made.intersect(o, d), made.all_hits(o, d)
    every = both.all_hits(o, d)
    front = np.einsum("ij,ij->i", every.normal, d[every.rays]) < 0
    assert np.array_equal(seen.t, every.t[front]) and 0 < len(seen) < len(every)
    assert np.array_equal(made.count_hits(o, d) > 0, hits.primitive >= 0)


def test_an_edge_is_hit_in_any_case() -> None:
    """Of boxes, polygons and faces of more than 3 corners, too: what is crossed is met, on a lattice."""
    random = np.random.default_rng(4)
    origins = random.integers(-6, 7, (3000, 3)) / 2
    ways = random.integers(-6, 7, (3000, 3)) / 2
    moves = ways.any(axis=1)
    origins, ways = origins[moves], ways[moves]
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    forms = {
        "box": [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}],
        "mesh": [{"type": "mesh", "vertices": corners, "faces": faces}],
        "polygons": [{"type": "polygon", "points": [corners[k] for k in face]} for face in faces],
    }
    met = {}
    for name, shapes in forms.items():
        with clrt.Tracer({"shapes": shapes}) as tracer:
            hit, count = np.isfinite(tracer.intersect(origins, ways).t), tracer.count_hits(origins, ways)
            assert np.array_equal(hit, tracer.occluded(origins, ways)), name
        assert hit[count > 0].all() and (hit & (count == 0)).sum() > 10, name
        met[name] = hit
    assert np.array_equal(met["box"], met["mesh"]) and np.array_equal(met["box"], met["polygons"])
