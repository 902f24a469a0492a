"""`clrt exercise`: a fault in a copy of the kernels, to find and to mend."""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
from pathlib import Path
from typing import Any

from clrt.base import child
from clrt.base.atomic import write_json
from clrt.base.errors import ClrtError, legible
from clrt.base.scratch import scratch
from clrt.cli.outputs import check_named
from clrt.cli.terminal import say

NOT_YET = 1  # exit code
_ROUNDING = 1e-5  # of radiance: what the same formula in another order differs by


def run(options: argparse.Namespace) -> int:
    """List, start, hint or check."""
    action: dict[str, Any] = {"list": _list, "start": _start, "hint": _hint, "check": _check}
    code: int = action[options.action](options)
    return code


def _list(options: argparse.Namespace) -> int:
    from clrt.exercises.table import exercises

    if options.json:
        rows = [{"exercise": one.number, "title": one.title, "picture": one.picture} for one in exercises()]
        print(json.dumps(rows, indent=2))
        return 0
    for one in exercises():
        print(f"{one.number:2}  {one.title}")
    print("clrt exercise start N DIR begins one")
    return 0


def _start(options: argparse.Namespace) -> int:
    from clrt.exercises.folder import start

    check_named("DIR", options.folder, f"exercise-{options.number}")
    made = start(options.number, Path(options.folder), options.device)
    one = made.exercise
    print(f"exercise {one.number}: {one.title}\n{one.picture}\n{made.folder / 'README.md'} says how to go on")
    return 0


def _hint(options: argparse.Namespace) -> int:
    from clrt.exercises.folder import next_hint, opened
    from clrt.exercises.table import HINTS

    found = opened(Path(options.folder))
    last = found.hints == HINTS
    hint = next_hint(found)
    print(f"hint {min(found.hints + 1, HINTS)} of {HINTS}{', again' if last else ''}: {hint}")
    return 0


def _check(options: argparse.Namespace) -> int:
    """Print a line for each folder; 1 where one is not mended yet."""
    if not 0 < options.timeout < 1e6:
        raise ClrtError(f"--timeout: {options.timeout} is not allowed; it is a number of seconds above 0")
    alone = len(options.folders) == 1
    rows = [_checked(options.folders[0], options)] if options.into else _apart(options)
    if alone and rows[0]["error"] and not options.json:
        raise ClrtError(rows[0]["error"])
    if options.into:  # and not to standard output, where kernels may print what they like
        write_json(options.into, rows[0])
    elif options.json:
        print(json.dumps(legible(rows), indent=2))
    elif alone:
        print("\n".join(_words(rows[0])))
    else:
        for row in rows:
            print(f"{row['folder']}: {_words(row)[0]}")
        print(f"{sum(row['mended'] for row in rows)} of {len(rows)} mended")
    return 0 if all(row["mended"] for row in rows) else NOT_YET


def _checked(name: str, options: argparse.Namespace) -> dict[str, Any]:
    """What is found of one folder, as `--json` prints it."""
    from clrt.exercises.folder import opened
    from clrt.exercises.judge import judged

    found = opened(Path(name))
    one = found.exercise
    row: dict[str, Any] = {
        "folder": name, "exercise": one.number, "title": one.title, "hints": found.hints, "error": None,
    }  # fmt: skip
    for finding in judged(one, found.kernels, options.device):
        row |= {"scene": finding.scene, "share": finding.share, "pixel": finding.pixel,
                "largest": finding.largest}  # fmt: skip
    row["mended"] = row["pixel"] is None
    return row


def _apart(options: argparse.Namespace) -> list[dict[str, Any]]:
    """The same of all folders, each by a process of its own: kernels of others may crash or never end."""
    rows = []
    for number, name in enumerate(options.folders, 1):
        if len(options.folders) > 1:
            say(f"{number} of {len(options.folders)}: {name}")
        with scratch() as folder:
            rows.append(_by_child(name, options, folder / "found.json"))
    return rows


def _by_child(name: str, options: argparse.Namespace, into: Path) -> dict[str, Any]:
    command = child.command("clrt", "exercise", "check", "--into", str(into))
    command += [] if options.device is None else ["--device", str(options.device)]
    row: dict[str, Any] = {"folder": name, "mended": False}
    try:
        done = subprocess.run(
            [*command, "--", name], capture_output=True, timeout=options.timeout, check=False,
            stdin=subprocess.DEVNULL, env=child.environment(),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return {**row, "error": f"no answer within {options.timeout:g} s"}
    if done.returncode in (0, NOT_YET) and into.is_file():
        found: dict[str, Any] = json.loads(into.read_bytes())
        return found
    if done.returncode < 0:
        return {**row, "error": f"the kernels end the process (signal {-done.returncode})"}
    said = done.stderr.decode(errors="replace").strip().splitlines()
    last = said[-1].removeprefix("clrt: error: ") if said else f"exit code {done.returncode}"
    return {**row, "error": last}


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share > 0.995 else f"{100 * share:.2g} %"


def _words(row: dict[str, Any]) -> list[str]:
    """A line that says how it is, and what more there is to say."""
    if row["error"]:
        return [f"not judged: {row['error']}"]
    from clrt.exercises.table import exercise, scenes

    one = exercise(row["exercise"])
    hints = f", {row['hints']} hint{'' if row['hints'] == 1 else 's'}" if row["hints"] else ""
    name = f"exercise {one.number}, {one.title!r}{hints}"
    if row["mended"]:
        return [f"{name}: mended; {len(scenes())} pictures are right, bit for bit", one.lesson]
    column, row_number = row["pixel"]
    own = row["scene"] == one.scene
    scene = f"scenes/{row['scene']}.toml"
    lines = [f"{name}: not yet; {_percent(row['share'])} of the pixels of {scene} are wrong"]
    if row["largest"] <= _ROUNDING:
        most = f"by no more than {row['largest']:.1g}, as of the right formula in another order"
        lines.append(f"{most}: write it as the lines around it do")
    if not own:
        why = "more was changed than the fault, or the wrong place was mended"
        lines.append(f"scenes/{one.scene}.toml is right, so {why}")
    where = f"{shlex.quote(str(Path(row['folder'], scene)))} {column} {row_number}"
    kernels = f"CLRT_KERNELS={shlex.quote(str(Path(row['folder'], 'kernels')))}"
    return [*lines, f"most at column {column}, row {row_number}: {kernels} clrt explain {where}"]
