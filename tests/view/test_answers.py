"""The viewer's server: what it answers, and to whom of those who wait."""

from __future__ import annotations

import json
import socket
import threading
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.images.file import encode
from clrt.view.server import Server
from clrt.view.session import Session
from tests.view_samples import EVIL, SCENE, SIZE, ask, scene

WIDTH, HEIGHT = SIZE
FRAME = {"page": "p", "number": 1, "width": WIDTH, "height": HEIGHT, "spp": 1}


def half(pixels: np.ndarray) -> bytes:
    return pixels.astype("<f2").tobytes()


def test_the_scene_is_told(server: Server) -> None:
    about, _ = ask(server, "open")
    assert about["title"] == f"{EVIL}.toml" and about["size"] == [WIDTH, HEIGHT]
    names = [name for group in about["layers"] for name in group["names"]]
    assert {"direct", "depth", "generation_3"} <= set(names) and "generation_4" not in names
    assert "xyz" not in names
    places = {knob["place"] for knob in about["knobs"]}
    some = {f'materials."{EVIL}".diffuse', 'materials."floor".color.colors[1]', "shapes[2].material.diffuse"}
    assert some | {"lights[0].position[1]", "lights[0].intensity", "max_depth", "background"} <= places
    assert not [place for place in places if "quotes" in place or "file" in place or "name" in place]


def test_frames_are_pictures_of_a_tracer(server: Server) -> None:
    fresh = clrt.Tracer(scene())
    table, data = ask(server, "frame", **FRAME)
    assert table == {"width": WIDTH, "height": HEIGHT, "layer": "image", "light": True}
    assert data == half(fresh.render(spp=1).pixels)
    for layer, light in (("depth", False), ("reflection", True), ("generation_1", True)):
        table, data = ask(server, "frame", **FRAME | {"layer": layer})
        assert table["light"] is light
        assert data == half(fresh.render(spp=1, layers=[layer]).layer(layer).pixels)
    camera = {"origin": [1, 2, 4], "target": [0, 0, 0.5], "up": [0, 1, 0], "fov": 50}
    changes = {f'materials."{EVIL}".reflection': 0.2, "lights[0].intensity": [1, 2, 3], "max_depth": 1}
    changed = scene().replace({**changes, **{f"camera.{name}": value for name, value in camera.items()}})
    _, data = ask(server, "frame", **FRAME, camera=camera, changes=changes)
    assert data == half(clrt.Tracer(changed).render(spp=1).pixels)
    assert ask(server, "frame", **FRAME)[1] == half(fresh.render(spp=1).pixels)  # nothing is left of them


POSE = [[1, 0, 0, 0.3], [0, -1, 0, 0.5], [0, 0, -1, 4], [0, 0, 0, 1]]
K = [[40, 0, 15], [0, 30, 12], [0, 0, 1]]  # oblong pixels, and not about the middle


@pytest.mark.parametrize(
    "view", [{"pose": POSE}, {"pose": POSE, "K": K}, {"origin": [0, 1, 4], "target": [0, 0, 0], "K": K}]
)
def test_cameras_by_pose_and_k_are_looked_at(view: dict[str, Any]) -> None:
    """The page starts with the scene's own picture; what it changes takes the place of what says the same."""
    fixed = clrt.load_dict({**SCENE, "camera": {**view, "width": WIDTH, "height": HEIGHT}})
    session, fresh = Session(clrt.Tracer(fixed)), clrt.Tracer(fixed)
    first = session.answer("open", {})[0]["camera"]
    assert fixed.camera and first["fov"] == fixed.camera.fov
    start = {name: first[name] for name in ("origin", "target", "up")}
    assert session.answer("frame", {**FRAME, "camera": start})[1] == half(fresh.render(spp=1).pixels)
    assert session.answer("pixel", {**FRAME, "x": 3, "y": 4, "camera": start})[0]["samples"] == 1
    moved = session.shown({"camera": {**start, "origin": [1, 1, 4]}})[1]
    assert moved.stated("K") == fixed.camera.stated("K") and moved.origin == (1, 1, 4)
    wide = session.shown({"camera": {**start, "fov": 60}})[1]
    assert wide.fov == 60 and not wide.has_k and wide.origin == fixed.camera.origin
    saved = session.answer("save", {"what": "scene", "camera": {**start, "fov": 60}})[1]
    assert clrt.load_dict(tomllib.loads(saved.decode())).camera == wide


@pytest.mark.parametrize(("spp", "most"), [(9, 36), (1, 4), (4, 64)])
def test_adaptive_scenes_are_looked_at_with_any_number_of_samples(spp: int, most: int) -> None:
    """Those of the scene's own number are its own pictures, all others are even."""
    table = {**SCENE, "camera": {**SCENE["camera"], "spp": spp}}
    plain = clrt.load_dict(table)
    own = plain.replace({"adaptive": {"spp": most}})
    tracer = clrt.Tracer(own)
    assert "<img" in tracer._repr_html_() and tracer.scene is own
    session, even = Session(clrt.Tracer(own)), clrt.Tracer(plain)
    assert session.answer("open", {})[0]["adaptive"] and not Session(even).answer("open", {})[0]["adaptive"]
    for asked in (1, 4, 9, 16):
        right = (tracer if asked == spp else even).render(spp=asked).pixels
        assert session.answer("frame", {**FRAME, "spp": asked})[1] == half(right)
        pixel, _ = session.answer("pixel", {**FRAME, "spp": asked, "x": 16, "y": 11})
        assert pixel["value"] == right[11, 16].tolist()
    saved = session.answer("save", {"what": "scene"})[1]
    assert clrt.load_dict(tomllib.loads(saved.decode())).adaptive == own.adaptive


def test_what_a_screen_shows_is_what_a_file_holds() -> None:
    """float16 moves a byte by at most one, in few pixels."""
    pixels = clrt.Tracer(scene()).render(spp=1).pixels
    shown, saved = encode(np.frombuffer(half(pixels), "<f2").astype(np.float32)), encode(pixels).reshape(-1)
    away = np.abs(shown.astype(int) - saved)
    assert away.max() <= 1 and (away > 0).mean() < 0.1


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"changes": {"background": "sky.exr"}}, "background: 'sky.exr' is not allowed; it must be like"),
        ({"changes": {"shapes[0].file": "/etc/passwd"}}, "cannot be changed here"),
        ({"changes": {"shapes[0].radius": 2}}, "cannot be changed here; edit the scene's file"),
        ({"changes": {"shapes": []}}, "cannot be changed here"),
        ({"changes": {"lights[0].intensity": "D65"}}, "must be like"),
        ({"changes": {"lights[0].intensity": [1, 2]}}, "must be like"),
        ({"changes": {"lights[0].position[0]": True}}, "must be like"),
        ({"changes": {"lights[0].position[0]": 1e300}}, "must be like"),
        ({"changes": {"lights[0].position[0]": float("nan")}}, "must be like"),
        ({"changes": {"max_depth": 1.5}}, "must be like"),
        ({"changes": {"shapes[2].material.diffuse": -1}}, "must be a number >= 0"),
        ({"changes": []}, "must be a table of places"),
        ({"camera": {"width": 9}}, "camera: 'width' cannot be changed here"),
        ({"camera": {"origin": [0, 0, 0]}}, "target must not be at the camera's origin"),
        ({"camera": {"fov": "wide"}}, "camera.fov"),
        ({"camera": 5}, "camera: 5"),
        ({"width": 0}, "width: 0"),
        ({"width": 4097}, "width: 4097"),
        ({"height": None}, "height: None"),
        ({"spp": 3}, "square"),
        ({"layer": "nothing"}, "is not a layer"),
        ({"layer": "generation_9"}, "is not a layer"),
        ({"layer": 5}, "layer: 5"),
        ({"number": "x"}, "number: 'x'"),
        ({"page": 5}, "page: 5"),
    ],
)
def test_wrong_questions_are_told_why(server: Server, body: dict[str, Any], words: str) -> None:
    table, data = ask(server, "frame", **FRAME | body)
    assert words in table["error"] and data == b""


STRANGE: list[Any] = [
    None, True, -1, 0, 1.5, 1e30, 1e300, -(10**40), float("nan"), float("inf"), "", "x", "\0", "\ud800",
    "..", "/etc/passwd", [], [1, 2], [1, 2, 3], ["x"] * 3, [None] * 3, [[1]] * 3, [1e300] * 3,
    [float("nan")] * 3,
    {}, {"origin": [0, 0]}, {"origin": [0, 0, 0]}, {"up": [0, 0, 0]}, {"up": [0, 0, 1], "origin": [0, 0, 9]},
    {"fov": 180}, {"fov": float("nan")}, {"aperture": 1e17}, {"focus": 0}, {"": 1}, {"camera.fov": 9},
    {"max_depth": 10**6}, {"max_depth": -1}, {"background": [1e29] * 3}, {"shapes[2].material.ior": 0},
    {"shapes[2].material.ior": "glass"}, {"shapes[2].material.transmission": 1, "max_depth": 0},
]  # fmt: skip


@pytest.mark.parametrize("kind", ["open", "frame", "pixel", "save"])
def test_nothing_that_is_asked_is_a_surprise(
    server: Server, kind: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Each part of a question in turn is strange: there is an answer, or it is told what is wrong."""
    right = {**FRAME, "x": 1, "y": 1, "what": "scene", "camera": {}, "changes": {}, "layer": "image"}
    right["exposure"] = 0
    told = 0
    for name in right:
        for value in STRANGE:
            table, data = ask(server, kind, **{**right, name: value})
            told += "error" in table
            assert "error" not in table or data == b""
    assert capfd.readouterr().err == ""
    assert told > 100 or kind == "open"


def test_light_that_is_not_finite_is_said(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.view.session.told", lambda tree: {"value": [float("nan")] * 3})
    table, _ = ask(server, "pixel", width=WIDTH, height=HEIGHT, x=3, y=4)
    assert table == {"error": "pixel (3, 4): its rays bring light that is not finite"}


def test_a_pixel_s_rays_sum_to_it(server: Server) -> None:
    tracer = clrt.Tracer(scene())
    for spp in (1, 4):
        table, _ = ask(server, "pixel", width=WIDTH, height=HEIGHT, spp=spp, x=16, y=11)
        value = tracer.render(spp=spp).pixels[11, 16]
        assert table["value"] == table["total"] == value.tolist()
        assert {ray["number"] for ray in table["rays"]} == {way["ray"] for way in table["ways"]}
        assert table["left_out"] == 0 and EVIL in table["rays"][0]["heading"]
        assert any(EVIL in solid["name"] for solid in table["solids"])
    assert "x: 99" in ask(server, "pixel", width=WIDTH, height=HEIGHT, x=99, y=1)[0]["error"]


def test_very_many_rays_are_cut_off(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.view.pixel.MOST", 1)
    table, _ = ask(server, "pixel", width=WIDTH, height=HEIGHT, spp=1, x=16, y=11)
    assert len(table["rays"]) == 1 and table["left_out"] > 0
    assert table["value"] == table["total"]


def test_solids_keep_their_outline(session: Session) -> None:
    tree = clrt.Tracer(scene()).explain(16, 11)
    from clrt.view.pixel import told

    (ball,) = [solid for solid in told(tree)["solids"] if "sphere" in solid["name"] or EVIL in solid["name"]][
        :1
    ]
    points = np.array(ball["points"])
    assert len(points) <= 240
    assert np.allclose(points.max(axis=0), 1, atol=0.03) and np.allclose(points.min(axis=0), -1, atol=0.03)


def test_the_scene_is_saved_as_it_is_shown(server: Server, tmp_path: Path) -> None:
    changes, camera = {"lights[0].position[1]": 7.0}, {"origin": [1, 1, 6]}
    table, data = ask(server, "save", what="scene", changes=changes, camera=camera)
    assert table["name"].endswith("-viewed.toml") and set("<>/'\" ").isdisjoint(table["name"])
    (tmp_path / "again.toml").write_bytes(data)
    again = clrt.load(tmp_path / "again.toml")
    assert again == scene().replace({**changes, "camera.origin": camera["origin"]})
    assert "what: 'all' is not allowed" in ask(server, "save", what="all")[0]["error"]


def test_pictures_are_saved_as_files_hold_them(server: Server, tmp_path: Path) -> None:
    image = clrt.Tracer(scene()).render(spp=4, layers=["depth"])
    for what in ("png", "exr"):
        table, data = ask(server, "save", **FRAME | {"spp": 4}, what=what, exposure=1.0)
        assert table["name"].endswith(f".{what}")
        (tmp_path / f"a.{what}").write_bytes(data)
        image.save(tmp_path / f"b.{what}", 1.0 if what == "png" else 0.0)
        found, right = (clrt.read_image(tmp_path / f"{name}.{what}") for name in "ab")
        assert found.tobytes() == right.tobytes()
    _, data = ask(server, "save", **FRAME, what="png", layer="depth", exposure=3.0)
    (tmp_path / "c.png").write_bytes(data)
    found = clrt.read_image(tmp_path / "c.png")
    image = clrt.Tracer(scene()).render(spp=1, layers=["depth"])
    image.layer("depth").save(tmp_path / "d.png")  # no exposure: it is no light
    assert found.tobytes() == clrt.read_image(tmp_path / "d.png").tobytes()


# --- who is still waiting


def test_the_last_question_of_a_page_wins(server: Server, session: Session) -> None:
    assert ask(server, "frame", **FRAME | {"page": "q", "number": 9})[1]
    assert ask(server, "frame", **FRAME | {"page": "q", "number": 8})[0] == {"superseded": True}
    assert ask(server, "frame", **FRAME | {"page": "r", "number": 1})[1]  # another page's
    for number in range(200):
        session.answer("frame", FRAME | {"page": f"many {number}", "number": 0})
    assert len(session._latest) <= 64


@pytest.mark.parametrize("what", ["png", "exr"])
def test_a_file_that_nobody_waits_for_is_none(session: Session, what: str) -> None:
    """A page that went away while a picture was made for it left a traceback."""
    asked = {"what": what, "width": 64, "height": 48, "spp": 1}
    assert session.answer("save", asked, lambda: True) == ({"superseded": True}, b"")


def test_a_picture_that_nobody_waits_for_is_given_up(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is superseded between two of its tiles; the next one has its right bits."""
    began, tiles = threading.Event(), []
    right = half(clrt.Tracer(scene()).render(spp=1).pixels)
    render = clrt.Tracer.render

    def slow(self: Any, *given: Any, **named: Any) -> Any:
        progress = named["progress"]

        def look(*counts: int) -> None:
            tiles.append(counts)
            began.set()
            if counts[1] == 256 * 192:
                newer.wait(20)
            progress(*counts)

        return render(self, *given, **named | {"progress": look})

    newer, found = threading.Event(), {}
    session.tracer._settings = clrt.Settings(tile=4096)
    monkeypatch.setattr(clrt.Tracer, "render", slow)
    large = {"page": "s", "number": 1, "width": 256, "height": 192, "spp": 1}
    first = threading.Thread(target=lambda: found.update(first=session.answer("frame", large)))
    first.start()
    assert began.wait(60)
    second = threading.Thread(
        target=lambda: found.update(second=session.answer("frame", FRAME | {"page": "s", "number": 2}))
    )
    second.start()
    while session._latest["s"] < 2:
        pass
    newer.set()
    first.join()
    second.join()
    assert found["first"] == ({"superseded": True}, b"")
    assert found["second"][1] == right
    assert len([counts for counts in tiles if counts[1] == 256 * 192]) < 12
    session.tracer._settings = clrt.Settings()


def test_a_page_that_goes_away_is_noticed(
    server: Server, session: Session, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """While its picture is made, and when the answer finds nobody."""
    asked, gone = threading.Event(), threading.Event()
    seen: list[bool] = []

    def waits(kind: str, body: Any, is_gone: Any) -> Any:
        seen.append(is_gone())
        asked.set()
        while not is_gone():
            gone.wait(0.01)
        seen.append(True)
        return {}, bytes(1 << 24)

    monkeypatch.setattr(session, "answer", waits)
    body = json.dumps(FRAME).encode()
    head = (f"POST /{server.token}/frame HTTP/1.1\r\nHost: {server.authority}\r\nOrigin: {server.origin}\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n")  # fmt: skip
    with socket.create_connection(("127.0.0.1", server.server_port)) as page:
        page.sendall(head.encode() + body)
        assert asked.wait(20)
    for _ in range(1000):
        if len(seen) == 2:
            break
        gone.wait(0.02)
    assert seen == [False, True]
    monkeypatch.undo()
    assert ask(server, "frame", **FRAME)[1]
    assert capfd.readouterr().err == ""
