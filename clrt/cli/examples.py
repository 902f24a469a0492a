"""Examples of each command, as its `--help` ends with them; a test reads them as the command line does."""

from __future__ import annotations

from typing import Final

EXAMPLES: Final[dict[str, tuple[tuple[str, str], ...]]] = {
    "render": (
        ("clrt render showcase -o showcase.png", "a scene that ships, at its own size"),
        ("clrt render room.toml -o room.exr --width 640 --layers depth,normal", "smaller, with layers"),
        ("clrt render a.toml b.toml -o 'out/{name}.png'", "several scenes"),
        ("clrt render - -o - --width 320 < room.toml > room.png", "from and to a pipe"),
        ("clrt render room.toml -o room.png --set camera.fov=30 --trace why.json", "a value, a trace"),
    ),
    "explain": (
        ("clrt explain showcase 808 353", "the tree in the terminal"),
        ("clrt explain showcase 808 353 --spp 1 -o why.html -o why.glb", "a page, a model"),
    ),
    "view": (
        ("clrt view showcase", "in your browser"),
        ("clrt view room.toml --no-browser --port 8080", "only says where; Ctrl-C ends it"),
    ),
    "check": (
        ("clrt check room.toml", "one scene"),
        ("clrt check --json *.toml", "many, for a program"),
    ),
    "hash": (
        ("clrt hash showcase --width 320", "of a picture that is rendered now"),
        ("clrt hash picture.exr", "of one that was saved"),
    ),
    "convert": (
        ("clrt convert balls.nff balls.toml", "another format"),
        ("clrt convert showcase showcase.xml", "for Mitsuba"),
        ("clrt convert -q showcase showcase.xml", "without a word of what Mitsuba lacks"),
        ("clrt convert balls.nff - | clrt render - -o balls.png", "within a pipe"),
    ),
    "sweep": (
        ("clrt sweep showcase --set materials.glass.ior=1.3:1.6:4 -o 'out/{index}.png'", "four pictures"),
        ("clrt sweep showcase --keyframes path.toml -o flight.mp4", "a flight through the scene"),
    ),
    "turntable": (("clrt turntable showcase --frames 120 --width 640 -o spin.mp4", "a video"),),
    "compare": (
        ("clrt compare mine.png theirs.png", "two pictures"),
        ("clrt compare mine.png room.toml --report why.html", "a picture, and what it should show"),
    ),
    "validate": (
        ("clrt validate room.toml", "your own scene, by independent programs"),
        ("clrt validate --against 'myrt {scene.toml} {out.exr}'", "your own program"),
    ),
    "bench": (
        ("clrt bench --only frames --scene showcase", "pictures of a scene"),
        ("clrt bench --json now.json", "everything, kept"),
        ("clrt bench --compare now.json", "what is slower since"),
        ("clrt bench --quick --only frames --device 0 --device 1", "two devices side by side"),
    ),
    "plot-spectrum": (("clrt plot-spectrum D65 -o d65.png", "a lamp"),),
    "devices": (("clrt devices --json", "for a program"),),
    "doctor": (("clrt doctor", "why nothing renders"),),
    "scenes": (("clrt scenes", "names that stand for files"),),
    "selftest": (("clrt selftest --quick", "is this driver right"),),
    "exercise": (
        ("clrt exercise start 1 shadow", "begin: a folder with a fault in it"),
        ("clrt exercise check shadow", "is it mended"),
        ("clrt exercise check --json ada/* grace/*", "a class"),
    ),
}
"""By command: what to type, and what for."""


_FIRST: Final = ("scenes", "render", "view", "explain", "check")


def epilog(command: str = "") -> str:
    """What stands below a command's options; below those of `clrt` itself, what to begin with."""
    shown = EXAMPLES.get(command, ()) if command else tuple(EXAMPLES[name][0] for name in _FIRST)
    return "\n".join(["examples:", *(f"  {line}\n      {what}" for line, what in shown)]) if shown else ""
