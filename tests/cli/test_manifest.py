"""The manifest of a series: which pictures are known, whatever ended or spoiled it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import clrt
from clrt.base.limits import Limits
from clrt.cli import main
from clrt.cli.manifest import Manifest
from clrt.engine.tracer import Tracer
from tests.growth import check_growth
from tests.series_samples import rows, run, times


def test_pictures_that_are_known_stay_known_whatever_ends_a_series(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sets = ("--set", "camera.fov=20:40:3")
    assert run(*sets) == 0
    all_three = rows()
    Path("00_20.png").unlink()
    render = Tracer.render

    def broken_off(self: Tracer, *arguments: Any, **named: Any) -> clrt.Image:
        raise KeyboardInterrupt

    monkeypatch.setattr(Tracer, "render", broken_off)
    assert run(*sets) == 130 and rows() == all_three, "nothing was done"
    seen: list[int] = []

    def counted(self: Tracer, *arguments: Any, **named: Any) -> clrt.Image:
        seen.append(len(rows()))  # what SIGKILL would leave
        if self.scene.camera.fov == 30:  # type: ignore[union-attr]
            raise KeyboardInterrupt
        return render(self, *arguments, **named)

    def watched(self: Tracer, *arguments: Any, **named: Any) -> clrt.Image:
        seen.append(len(rows()) if Path("frames.csv").exists() else 0)
        return render(self, *arguments, **named)

    monkeypatch.setattr(Tracer, "render", counted)
    Path("01_30.png").unlink()
    assert run(*sets) == 130 and [row["file"] for row in rows()] == [row["file"] for row in all_three]
    Path("frames.csv").unlink()
    monkeypatch.setattr("clrt.cli.manifest._SHARE", 1e9)
    monkeypatch.setattr(Tracer, "render", watched)
    seen.clear()
    assert run(*sets) == 0 and seen == [0, 1, 2], "it is saved while the series goes on"


def test_other_series_in_the_folder_stay_known(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As long as their files are there; a shorter run of the same series forgets nothing either."""
    first = ("--set", "camera.fov=20:40:3")
    second = ["sweep", "s.toml", "-o", "b{index}.png", "--set", "ambient=0,0.2"]
    assert run(*first) == 0
    known = {row["file"]: row for row in rows()}
    assert main(second) == 0 and run("--set", "camera.fov=20") == 0
    found = {row["file"]: row for row in rows()}
    assert [*found] == ["00_20.png", "b0.png", "b1.png", "01_30.png", "02_40.png"], "its own first"
    for name in ("01_30.png", "02_40.png"):
        assert {place: found[name][place] for place in known[name]} == known[name]
    assert found["b1.png"]["ambient"] == "0.2" and found["b1.png"]["camera.fov"] == ""
    capsys.readouterr()
    assert main(second) == 0 and "2 pictures, 2 of them were there" in capsys.readouterr().out
    Path("02_40.png").unlink()
    before = times()
    assert run(*first) == 0 and before.items() <= times().items() and "02_40.png" not in before
    Path("b0.png").unlink()
    assert run(*first) == 0 and [row["file"] for row in rows()][3:] == ["b1.png"], "what is gone is forgotten"


def test_a_folder_for_each_picture(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Pictures of one name in different folders are told apart; rows of older versions lack the folder."""
    for folder in ("20", "40"):
        Path("out", folder).mkdir(parents=True)
    words = ["sweep", "s.toml", "-o", "out/{camera.fov}/f.png", "--set", "camera.fov=20,40", "--manifest"]
    for manifest in ("out/frames.csv", "20.csv"):
        assert main([*words, manifest]) == 0
        capsys.readouterr()
        assert main([*words, manifest]) == 0 and "2 pictures, 2 " in capsys.readouterr().out
    assert [row["file"] for row in rows("out/frames.csv")] == ["20/f.png", "40/f.png"]
    text = Path("20.csv").read_text().replace("out/20/", "").replace("out/40/", "")
    Path("20.csv").write_text(text)
    assert main([*words, "20.csv"]) == 0 and "2 pictures, 2 " in capsys.readouterr().out
    assert [row["file"] for row in rows("20.csv")] == ["out/20/f.png", "out/40/f.png"]


def test_a_manifest_that_a_spreadsheet_saved_is_one(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With a mark of its encoding before the first line."""
    words = ["sweep", "s.toml", "-o", "{camera.fov}.png", "--set", "camera.fov=20,40"]
    assert main(words) == 0
    Path("frames.csv").write_bytes(b"\xef\xbb\xbf" + Path("frames.csv").read_bytes())
    assert main(words) == 0 and "2 pictures, 2 " in capsys.readouterr().out


def test_a_manifest_of_many_columns_is_read_in_linear_time(scene: Path) -> None:
    def make(n: int) -> Callable[[], object]:
        names = ["index", "file", *(f"c{k}" for k in range(n)), "picture", "sha256", "identity", "rays"]
        Path(f"{n}.csv").write_text(",".join(names) + "\n" + "1,a\n" * n)
        return lambda: Manifest(f"{n}.csv", ["a.png"], [], Limits())

    check_growth(make, 1500)
    names = ",".join(["index", "file", "picture", "sha256", "identity", "rays"]) + "\n"
    asked: list[str] = []
    exists = os.path.exists
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os.path, "exists", lambda path: asked.append(path) or exists(path))
        Path("m.csv").write_text(names + "0,d/a,,x,,\n,,,x,,\n" * 1000)
        Manifest("m.csv", ["a"], [], Limits())
    assert asked == ["d/a"], "a system call for each name, not for each row"
    Path("m.csv").write_text(names + "0,a\n")
    assert Manifest("m.csv", ["a"], [], Limits())._before == {}


def test_a_file_of_any_size_at_a_frame_s_name_is_not_looked_through(scene: Path) -> None:
    """Its picture is made anew, as where any other file lies there; one within the limit is kept."""
    words = ("--set", "camera.fov=20,40")
    assert run(*words) == 0
    kept, large = (row["file"] for row in rows())
    whole = Path(large).read_bytes()
    with Path(large).open("r+b") as file:
        file.truncate(1 << 40)  # without taking any room: hours to read
    before = times()[kept]
    assert run(*words) == 0
    assert Path(large).read_bytes() == whole and times()[kept] == before


def test_a_manifest_replaces_only_manifests(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for theirs in (b"frame,take\n1,7\n", b"\xff\xfe\x00", b"index;file\n"):
        Path("frames.csv").write_bytes(theirs)
        assert run("--set", "camera.fov=20") == 2
        assert "frames.csv: is there, and is no manifest of clrt; give --manifest" in capsys.readouterr().err
        assert Path("frames.csv").read_bytes() == theirs and not [*Path().glob("*.png")]
    Path("frames.csv").write_bytes(b"")  # nobody's
    assert run("--set", "camera.fov=20") == 0 and len(rows()) == 1


DAMAGES = (
    (b",picture,", b",painting,"),  # a column that is missing
    (b"\n0,", b"\n\xff\xfe,"),
    (b"20.0,", b'"20.0,'),  # a quote that nothing ends
    (b"0 ,", b"0 "),
)


def test_damaged_manifests_are_written_anew(scene: Path) -> None:
    assert run("--set", "camera.fov=20:30:2", "--max-depth", "0") == 0
    good, pictures = Path("frames.csv").read_bytes(), [row["picture"] for row in rows()]
    for old, new in DAMAGES:
        Path("frames.csv").write_bytes(good.replace(old, new, 1))
        assert run("--set", "camera.fov=20:30:2", "--max-depth", "0") == 0, new
        assert [row["picture"] for row in rows()] == pictures, new


@pytest.mark.parametrize("name", [f"{odd}{{index}}.png" for odd in ("=1+1", "\udcff", "a\nb", "\x1b")])
def test_pictures_of_any_name_go_on(name: str, scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["sweep", "s.toml", "-o", name, "--set", "camera.fov=20:30:2", "--max-depth", "0"]
    assert main(command) == 0 and main(command) == 0
    assert "2 of them were there" in capsys.readouterr().out
