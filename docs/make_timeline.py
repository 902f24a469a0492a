"""Draw timeline.png of performance.md anew: `python docs/make_timeline.py`. One picture's trace, as rows."""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parent))

from clrt.cli import main as clrt  # noqa: E402
from clrt.images.plotting import drawing, save, subplots  # noqa: E402

SCENE, WIDTH = "showcase", 640
NAMED: Final = 9  # passes with a colour of their own: those that take longest


def trace() -> list[dict[str, Any]]:
    """The events of a picture's trace, in Chrome's format, once its kernels are built."""
    with TemporaryDirectory() as folder:
        when = Path(folder, "when.json")
        for _ in range(2):
            picture = str(Path(folder, "a.png"))
            options = ["--width", str(WIDTH), "--spp", "1", "--quiet", "--trace", str(when)]
            assert clrt(["render", SCENE, "-o", picture, *options]) == 0
        events: list[dict[str, Any]] = json.loads(when.read_text("utf-8"))["traceEvents"]
        return events


@drawing()
def main() -> None:
    """A row for the host and for each track; what is generated, traced, shaded and waited for, in ms."""
    events = trace()
    rows = {event["tid"]: event["args"]["name"] for event in events if event["name"] == "thread_name"}
    spans = [event for event in events if event["ph"] == "X"]
    begin = min(event["ts"] for event in spans if event["name"] == "generate")
    spans = [event for event in spans if event["ts"] >= begin]
    taken: Counter[str] = Counter()
    for event in spans:
        taken[event["name"] if event["cat"] == "pass" else event["cat"]] += event["dur"]
    figure, axes = subplots(figsize=(9, 2.6))
    named = [name for name, _ in taken.most_common() if name not in ("wait", "copy")][:NAMED]
    others = {"other passes": "#999999", "copy": "#000000", "wait": "#dddddd"}
    shown = {name: f"C{number}" for number, name in enumerate(named)} | others
    for name, colour in shown.items():
        for row in rows:
            bars = [
                ((event["ts"] - begin) / 1e3, event["dur"] / 1e3)
                for event in spans if event["tid"] == row and _kind(event, named) == name
            ]  # fmt: skip
            axes.broken_barh(bars, (len(rows) - row - 0.4, 0.8), facecolors=colour, linewidth=0)
        axes.barh(0, 0, color=colour, label=name)
    axes.set_yticks([len(rows) - row for row in rows], list(rows.values()))
    axes.set_ylim(0.5, len(rows) + 0.5)
    axes.set_xlabel("ms")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8, frameon=False)
    save(figure, FOLDER / "timeline.png")


def _kind(event: dict[str, Any], named: list[str]) -> str:
    if event["cat"] != "pass":
        return str(event["cat"])
    return event["name"] if event["name"] in named else "other passes"


if __name__ == "__main__":
    main()
