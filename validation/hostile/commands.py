"""Hostile command lines, environments and descriptors: each index of a seed gives one run of `clrt`.

A run begins as one that works; then one or two things about it become odd. Paths that are written to lie in
the run's own folder, or where nobody can write.
"""

from __future__ import annotations

import errno
import json
import os
import random
import stat
import struct
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any, Final

from . import archives, oddities, pictures, seeds
from .mutate import spoil_bytes
from .oddities import MANY, NAMES, NEIGHBOURS, OPTIONS, PLACES, SPELLINGS, STREAMS, VALUES, VARIABLES

DANGLING: Final = b"nothing here"  # where such a link leads
TRIANGLE: Final = struct.pack("<6f", 1, 0, 0, 0, 1, 0)  # its last two corners
TREE: Final = {
    "asset": {"version": "2.0"}, "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
    "scenes": [{"nodes": [0]}],
}  # fmt: skip
_NO_PLACE: Final = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EMFILE)  # the machine's
_ALL: Final = 1 << 20  # bytes of arguments; Linux takes 2 MiB of them and the environment
_EACH: Final = 9  # bytes beside an argument's own: its end and its address
SCENE: Final = seeds.as_toml({**seeds.RESUMED, "max_depth": 2})

PATH: Final = b"[[keyframes]]\n[[keyframes]]\norigin = [3, 1, 4]\n"
MANIFEST: Final = b"index,file,camera.fov,picture,sha256,identity,rays\n0,out0.png,20,a,b,c 0,9\n"
BEGUN: Final = b'{"exercise": 1, "hints": 1, "version": "0.1.0", "kernels": ""}'


@dataclass
class Command:
    """A run of `clrt` in a folder of its own.

    files: contents by name, or what else stands there ("fifo", "folder", "loop", "dangling", "socket"), or
    "-> target" for a link. outputs: the files and folders that it may write. environment: None removes a
    variable. limits: of the shell's `ulimit`.
    """

    arguments: list[bytes]
    outputs: list[bytes]
    files: dict[bytes, bytes | str]
    environment: dict[bytes, bytes | None] = field(default_factory=dict)
    stdin: str = "null"
    stdout: str = "pipe"
    stderr: str = "pipe"
    limits: dict[str, int] = field(default_factory=dict)

    def prepare(self, folder: Path) -> None:
        """Make the folder with its files, but those that the system refuses, such as names too long."""
        folder.mkdir(parents=True)
        for name, what in self.files.items():
            try:
                _place(os.path.join(os.fsencode(folder), name), what)
            except OSError as error:
                if error.errno in _NO_PLACE:
                    raise

    def told(self) -> dict[str, Any]:
        """What a report shows."""
        odd = {
            _text(name): None if value is None else _text(value) for name, value in self.environment.items()
        }
        streams = [self.stdin, self.stdout, self.stderr]
        words = [_text(argument) for argument in self.arguments]
        return {"arguments": words, "environment": odd, "streams": streams, "limits": self.limits}


def make(seed: int, index: int) -> Command:
    """Command `index` of the ones that `seed` draws."""
    draw = random.Random(f"command {seed} {index}")
    run = draw.choice(_RUNS)(draw)
    for _ in range(draw.choice((1, 1, 2))):
        draw.choice(_CHANGES)(draw, run)
    run.arguments = _startable(run.arguments)
    return run


def _startable(arguments: list[bytes]) -> list[bytes]:
    """The first ones, as many as a process can be started with: a system has limits of its own."""
    ends = accumulate(len(argument) + _EACH for argument in arguments)
    return [argument for argument, end in zip(arguments, ends, strict=True) if end <= _ALL]


def _render(draw: random.Random) -> Command:
    out = draw.choice((b"out.png", b"out.exr", b"out.tif", b"out.jpg", b"out.bmp"))
    arguments, outputs = [b"render", b"scene.toml", b"-o", out, b"--width", b"8"], [out]
    for option, name in ((b"--stats", b"out.json"), (b"--checkpoint", b"out.ck")):
        if draw.random() < 0.3:
            arguments += [option, name]
            outputs.append(name)
    old: dict[bytes, bytes | str] = {out: seeds.images()[".png"]} if draw.random() < 0.3 else {}
    return Command(arguments, outputs, {b"scene.toml": SCENE, **old})


def _buffers(draw: random.Random) -> Command:
    """A glTF file, and an output that may be the buffer that it names."""
    buffer = draw.choice((b"out.png", b"tree.bin"))
    text = json.dumps({**TREE, "buffers": [{"uri": buffer.decode(), "byteLength": 36}]}).encode()
    files: dict[bytes, bytes | str] = {b"tree.gltf": text, buffer: bytes(12) + TRIANGLE}
    more: tuple[list[bytes], ...] = (
        [], [b"--stats", buffer], [b"--stats", buffer + b"/"], [b"--checkpoint", b"./" + buffer],
    )  # fmt: skip
    arguments = [b"render", b"tree.gltf", b"-o", b"out.png", b"--width", b"8", *draw.choice(more)]
    return Command(arguments, [] if buffer == b"out.png" else [b"out.png"], files)


def _hash(draw: random.Random) -> Command:
    name = draw.choice((b"scene.toml", b"a.exr"))
    files: dict[bytes, bytes | str] = {b"scene.toml": SCENE, b"a.exr": seeds.images()[".exr"]}
    return Command([b"hash", name], [], files)


def _convert(draw: random.Random) -> Command:
    out = draw.choice((b"out.toml", b"out.json", b"out.xml"))
    return Command([b"convert", b"scene.toml", out], [out], {b"scene.toml": SCENE})


def _compare(draw: random.Random) -> Command:
    suffix = draw.choice((".png", ".exr", ".jpg"))
    data = seeds.images()[suffix]
    names = [f"{letter}{suffix}".encode() for letter in "ab"]
    return Command([b"compare", *names, *draw.choice(([], [b"--json"]))], [], dict.fromkeys(names, data))


def _series(draw: random.Random) -> Command:
    """Pictures of a sweep, of a camera's path or from around."""
    name = draw.choice(oddities.TEMPLATES) if draw.random() < 0.5 else oddities.TEMPLATES[0]
    kinds: tuple[list[bytes], ...] = (
        [b"sweep", b"scene.toml", b"--set", b"camera.fov=20,40"],
        [b"sweep", b"scene.toml", b"--keyframes", b"path.toml", b"--frames", b"2"],
        [b"turntable", b"scene.toml", b"--frames", b"2"],
    )
    files: dict[bytes, bytes | str] = {b"scene.toml": SCENE, b"path.toml": PATH}
    if draw.random() < 0.3:
        files[b"frames.csv"] = MANIFEST
    outputs = [b"frames.csv", b"20.png", b"40.png", name]
    for n in range(120):  # pictures around, where their number is left out
        for word, value in ((b"{index}", b"%d"), (b"{index!r}", b"%d"), (b"{index:03}", b"%03d")):
            outputs.append(name.replace(word, value % n))
    return Command([*draw.choice(kinds), b"-o", name, b"--width", b"8"], outputs, files)


def _explain(draw: random.Random) -> Command:
    outputs = draw.sample((b"why.json", b"why.html", b"why.glb"), draw.choice((0, 1, 3)))
    written = [word for name in outputs for word in (b"-o", name)]
    arguments = [b"explain", b"scene.toml", draw.choice((b"4", b"0", b"99", b"-1")), b"3", *written]
    return Command([*arguments, *draw.choice(([], [b"--json"]))], outputs, {b"scene.toml": SCENE})


def _check(draw: random.Random) -> Command:
    names = [b"scene.toml", b"b.toml"][: draw.choice((1, 2))]
    files: dict[bytes, bytes | str] = dict.fromkeys(names, SCENE)
    return Command([b"check", *names, *draw.choice(([], [b"--json"], [b"--quiet"]))], [], files)


def _exercise(draw: random.Random) -> Command:
    """Its list, one that is begun, and a hint; a check takes longer than all others together."""
    kinds: tuple[tuple[list[bytes], list[bytes]], ...] = (
        ([b"list"], []), ([b"list", b"--json"], []), ([b"check", b"nothing"], []),
        ([b"hint", b"ex"], [b"ex/exercise.json"]), ([b"hint", b"."], [b"exercise.json"]),
        ([b"start", b"1", b"ex"], []), ([b"start", draw.choice((b"1", b"2", b"0", b"99")), b"new"], [b"new"]),
    )  # fmt: skip
    arguments, outputs = draw.choice(kinds)
    files: dict[bytes, bytes | str] = {b"ex/exercise.json": BEGUN, b"exercise.json": BEGUN}
    return Command([b"exercise", *arguments], outputs, files)


def _plot(draw: random.Random) -> Command:
    return Command(
        [b"plot-spectrum", draw.choice((b"D65", b"glass", b"gold")), b"-o", b"out.svg"], [b"out.svg"], {}
    )


def _plain(draw: random.Random) -> Command:
    kinds: tuple[list[bytes], ...] = (
        [b"devices"], [b"scenes"], [b"doctor"], [b"doctor", b"--json"], [b"--help"], [b"--version"], [],
        [b"bench", b"--only", b"nothing"], [b"validate", b"--case", b"nothing"],
        [b"selftest", b"--device", b"nothing"],
    )  # fmt: skip
    return Command(list(draw.choice(kinds)), [], {})


def _odd_option(draw: random.Random, run: Command) -> None:
    """An option with a value that nobody means; or one too many, too few, in a strange place."""
    choice = draw.random()
    if choice < 0.7:
        option = draw.choice(OPTIONS)
        meant = oddities.MEANT.get(option, ())
        values = [
            draw.choice(meant if meant and draw.random() < 0.7 else VALUES)
            for _ in range(4 if option == b"--crop" else draw.choice((0, 1, 1, 1, 1, 2)))
        ]
        if option in oddities.WRITTEN:
            values = [oddities.WRITTEN[option]]
            run.outputs = [*run.outputs, *values]
        if values and len(values) == 1 and draw.random() < 0.3:
            run.arguments.append(option + b"=" + values[0])
        else:
            run.arguments += [option, *values]
    elif choice < 0.8:
        run.arguments += [draw.choice(VALUES[-20:])] * draw.choice(MANY)
    elif choice < 0.9:
        run.arguments += [b"--limit", b"depth=9"] * draw.choice(MANY)
    elif run.arguments:
        del run.arguments[draw.randrange(len(run.arguments))]


def _odd_path(draw: random.Random, run: Command) -> None:
    """A file with a strange name, or something else than a file, or the same one twice."""
    named = [n for n, word in enumerate(run.arguments) if word in run.files or word in run.outputs]
    if not named:
        return
    at = draw.choice(named)
    old, choice = run.arguments[at], draw.random()
    suffix = os.path.splitext(old)[1]
    if choice < 0.5:
        new = draw.choice(NAMES) + suffix
        if old in run.files and len(new) < 255:
            run.files[new] = run.files.pop(old)
        if old in run.outputs:
            run.outputs[run.outputs.index(old)] = new
        run.arguments = [new if word == old else word for word in run.arguments]
    elif choice < 0.8:
        run.files[old] = what = draw.choice(PLACES)
        run.outputs += [DANGLING] if what == "dangling" and old in run.outputs else []
    elif choice < 0.9:
        others = [
            b"missing" + suffix,
            b"missing/x" + suffix,
            b"/proc/x" + suffix,
            b"",
            b".",
            suffix,
            b"x",
            b"x.png",
        ]
        run.arguments[at] = draw.choice(others)
        run.outputs.append(run.arguments[at])
    else:  # one file for two things
        before, behind = draw.choice(SPELLINGS)
        run.arguments[at] = before + run.arguments[draw.choice(named)] + behind


def _odd_file(draw: random.Random, run: Command) -> None:
    """A file with spoiled contents; a checkpoint where there was none."""
    if b"out.ck" in run.outputs:
        run.files[b"out.ck"] = archives.spoil(draw, seeds.checkpoint())
    for name, data in run.files.items():
        if isinstance(data, bytes):
            suffix = os.path.splitext(name)[1].decode(errors="replace")
            try:
                spoiled = pictures.spoil(draw, suffix, data)
            except (struct.error, ValueError, LookupError):  # it was spoiled before
                spoiled = data
            run.files[name] = spoiled if spoiled != data else spoil_bytes(draw, data)


def _environment(draw: random.Random, run: Command) -> None:
    """A variable that means something strange, or is not there."""
    for _ in range(draw.choice((1, 1, 2, 4))):
        name = draw.choice(list(VARIABLES))
        run.environment[name] = None if draw.random() < 0.1 else draw.choice(VARIABLES[name])
    run.files |= {b"file": b"x", b"loop": "loop", b"world": "world", b"spoiled": "spoiled", b"pipe": "fifo"}


def _streams(draw: random.Random, run: Command) -> None:
    run.stdin = draw.choice(("null", "closed", "full", "terminal"))
    run.stdout, run.stderr = draw.choice(STREAMS), draw.choice(STREAMS)
    if draw.random() < 0.5:  # something to say there: a warning
        run.files = {
            **run.files,
            b"scene.toml": SCENE.replace(b"radius = 1", b"radius = 1\nmaterial = {shininess = 5}"),
        }


def _neighbours(draw: random.Random, run: Command) -> None:
    """Files in the current folder that others would obey or run."""
    for name in draw.sample(list(NEIGHBOURS), draw.choice((1, 2, len(NEIGHBOURS)))):
        run.files[name] = draw.choice(NEIGHBOURS[name])
    run.files[b"neighbour/matplotlibrc"] = b"font.size: \xff"


def _limits(draw: random.Random, run: Command) -> None:
    """Less of something than usual: open files, bytes of a file, address space."""
    kind = draw.choice("nfv")
    run.limits[kind] = draw.choice({
        "n": (8, 16, 32, 64), "f": (0, 1, 8, 64), "v": (400_000, 1_000_000, 2_000_000),
    }[kind])  # fmt: skip


_RUNS: Final = (
    _render, _render, _render, _render, _buffers, _hash, _convert, _compare, _plot, _plain, _plain,
    _series, _series, _explain, _check, _exercise, _exercise,
)  # fmt: skip
_CHANGES: Final = (
    _odd_option, _odd_option, _odd_path, _odd_path, _odd_file, _environment, _streams, _limits, _neighbours,
)  # fmt: skip


def _place(path: bytes, what: bytes | str) -> None:
    """A file, or something else."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    if isinstance(what, bytes):
        with open(path, "wb") as file:
            file.write(what)
        return
    if os.path.lexists(path):
        os.unlink(path)
    if what == "fifo":
        os.mkfifo(path)
    elif what == "socket":
        os.mknod(path, stat.S_IFSOCK | 0o600)
    elif what == "loop":
        os.symlink(os.path.basename(path), path)
    elif what == "dangling":
        os.symlink(DANGLING, path)
    elif what.startswith("-> "):
        os.symlink(what[3:], path)
    else:
        os.mkdir(path)
        if what == "world":  # anybody may put something there
            os.chmod(path, 0o777)
        if what == "spoiled":
            for name in ("clrt/kernels", "pocl/kcache", "pytools/pdict-v4-pyopencl", "matplotlib"):
                folder = os.path.join(path, os.path.dirname(name).encode())
                os.makedirs(folder, exist_ok=True)
                Path(os.fsdecode(path), name).write_bytes(b"\x80\x04spoiled")


def _text(data: bytes) -> str:
    return data.decode(errors="backslashreplace")[:200]
