"""What can be asked for on the command line.

Nothing but argparse is imported before the command is known, so that help comes at once.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from typing import Any, Final, NoReturn

from clrt.base.errors import ClrtError, show
from clrt.base.layers import LAYERS
from clrt.cli.examples import epilog
from clrt.cli.terminal import FAULT, say
from clrt.version import __version__

MOST: Final = 2**31 - 1


def device(text: str) -> int | str:
    """A device as `clrt.render` takes it: a number of `clrt devices`, or a part of its name."""
    if not text.strip():
        right = "it must be a number of `clrt devices`, or a part of a device's name"
        raise argparse.ArgumentTypeError(f"{show(text)} is not allowed; {right}")
    return whole(text) if text.isdecimal() else text


def whole(text: str) -> int:
    """A whole number that a computation may take for one: of at most 32 bits."""
    if re.fullmatch(r"[+-]?[0-9]{1,10}", text) is None or abs(int(text)) > MOST:
        raise argparse.ArgumentTypeError(f"{show(text)} is not a whole number from -{MOST} to {MOST}")
    return int(text)


def number(text: str) -> float:
    """A number as scene files write it, or inf or nan, which each option judges; float() takes 1_0, too."""
    if re.fullmatch(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?|inf|nan)", text) is None:
        raise argparse.ArgumentTypeError(f"{show(text)} is not a number")
    return float(text)


def read(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command and its options. Leaves, after one line on stderr, where they are wrong."""
    made = parser()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given and given[0] not in made.commands and not given[0].startswith("-"):
        from clrt.base.places import did_you_mean

        near = did_you_mean(given[0], made.commands)
        raise ClrtError(f"{show(given[0])} is no command{near} (commands: {', '.join(made.commands)})")
    return made.parse_args(given)


class _Parser(argparse.ArgumentParser):
    """Faults on the command line are one line, like all others."""

    commands: dict[str, Any]

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        self.given: dict[str, Any] = {}  # values by option
        for action in (None, "store"):
            self.register("action", action, _Single)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """All must be known to the command: by `parse_args` it would be `clrt`, whose help has no option."""
        self.given = {}
        options, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return options, left

    def _get_values(self, action: argparse.Action, arg_strings: list[str]) -> Any:
        """As argparse does since 3.13: before, `--width=--` was no text at all, and the option's value []."""
        if action.option_strings and arg_strings == ["--"] and action.nargs in (None, argparse.OPTIONAL):
            value = self._get_value(action, "--")
            self._check_value(action, value)
            return value
        return super()._get_values(action, arg_strings)

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        """An empty name of a file is none: some commands took it for one that was not given."""
        if not arg_string and action.option_strings and action.type is None:
            raise argparse.ArgumentError(action, "'' is empty; it must not be")
        return super()._get_value(action, arg_string)

    def error(self, message: str) -> NoReturn:
        say(f"error: {message}; `{self.prog} --help` shows what there is")
        sys.exit(FAULT)


def parser() -> _Parser:
    """All commands with their options."""
    formatter = argparse.RawDescriptionHelpFormatter
    text = "A Whitted ray tracer in OpenCL."
    made = _Parser(
        prog="clrt", description=text, epilog=epilog(), formatter_class=formatter, allow_abbrev=False
    )
    made.add_argument("--version", action="version", version=f"clrt {__version__}")
    commands = made.add_subparsers(dest="command", metavar="COMMAND", required=True)

    def command(name: str, text: str) -> argparse.ArgumentParser:
        more = epilog(name)
        added = commands.add_parser(
            name, help=text, description=text, epilog=more, formatter_class=formatter, allow_abbrev=False
        )
        added.add_argument("-v", "--verbose", action="count", default=0, help="say what is done (-vv: more)")
        return added

    render = command("render", "Render a scene to a picture; or several, each to its own.")
    render.add_argument("scene", metavar="SCENE", nargs="+", help=_SCENE)
    text = ".exr .png .tif .jpg .bmp; '-': PNG to standard output; of several scenes 'out/{name}.png'"
    render.add_argument("-o", "--output", metavar="OUT", required=True, help=text)
    _add_frame(render, spp=" (the scene's; where it says none, 4 for .png .jpg .bmp)")
    names = ", ".join((*LAYERS, "generation_0 ..."))
    render.add_argument("--layers", type=_names, default=(), metavar="A,B", help=f"all, or some of {names}")
    render.add_argument("--stats", metavar="FILE.json", help="write counts of rays and times")
    render.add_argument("--trace", metavar="FILE.json", help=_TRACE)
    render.add_argument("--exposure", type=number, default=0.0, metavar="EV", help="brighten by EV stops")
    render.add_argument("--view", metavar="NAME", help=_VIEW)
    render.add_argument("--bits", type=whole, choices=(8, 16), help="bits per sample of .png and .tif (8)")
    render.add_argument("--checkpoint", metavar="FILE", help="keep what is finished; go on from it later")
    render.add_argument("--check", action="store_true", help="name the first number that is not finite")
    render.add_argument("-q", "--quiet", action="store_true", help="neither progress nor a closing line")

    explain = command("explain", "Say where a pixel's light comes from: all its rays as a tree.")
    _add_scene(explain)
    explain.add_argument("x", metavar="X", type=whole, help="column of the pixel, from 0 at the left")
    explain.add_argument("y", metavar="Y", type=whole, help="row of the pixel, from 0 at the top")
    explain.add_argument(
        "-o", "--output", metavar="OUT", action="append", default=[],
        help=".html, .json or .glb (rays as tubes among the shapes); may be repeated",
    )  # fmt: skip
    explain.add_argument("--json", action="store_true", help="print JSON")
    explain.add_argument(
        "--least", type=number, default=0.5, metavar="PERCENT",
        help="leave out branches that bring less of the pixel (0.5)",
    )  # fmt: skip
    explain.add_argument("-q", "--quiet", action="store_true", help="print nothing")
    _add_frame(explain, crop=False)

    view = command("view", "Show a scene in a browser: turn it, change it, look into its pixels.")
    _add_scene(view)
    view.add_argument("--port", type=whole, default=0, metavar="N", help="port of 127.0.0.1 (a free one)")
    view.add_argument("--no-browser", dest="browser", action="store_false", help="only print the address")
    _add_device(view)
    view.add_argument("--threads", type=whole, metavar="N", help="CPU threads")
    _add_set(view, _SET)
    _add_limit(view)

    check = command("check", "Say whether scenes are right, and what is in them, without rendering.")
    check.add_argument("scenes", metavar="SCENE", nargs="+", help=_SCENE)
    check.add_argument("--json", action="store_true", help="print JSON")
    check.add_argument("-q", "--quiet", action="store_true", help="only what is wrong")
    _add_set(check, _SET)
    _add_limit(check)

    _add_cluster(render)

    hashing = command("hash", "Print the hash of a scene's picture, or of the pixels in an .exr file.")
    _add_scene(hashing)
    hashing.add_argument("--json", action="store_true", help="print JSON")
    _add_frame(hashing)

    convert = command("convert", "Read a scene in any known format; write it in another one.")
    convert.add_argument("input", metavar="IN", help=_SCENE)
    text = ".toml, .json, .xml (for Mitsuba), .pov (POV-Ray), .nff, or '-': TOML to standard output"
    convert.add_argument("output", metavar="OUT", help=text)
    convert.add_argument("-q", "--quiet", action="store_true", help="not what the other format lacks")
    _add_set(convert, _SET)
    _add_limit(convert)

    sweep = command("sweep", "Render a scene for every combination of some values, to files or a video.")
    _add_scene(sweep)
    sweep.add_argument("-o", "--output", metavar="OUT", required=True, help=_FRAMES)
    sweep.add_argument("--keyframes", metavar="FILE", help="go along a camera's path: a .toml or .json file")
    sweep.add_argument("--frames", type=whole, metavar="N", help="pictures of the path (by its times, 120)")
    _add_frame(sweep, many=True)
    _add_series(sweep)

    turntable = command("turntable", "Render a scene from all around, to files or a video.")
    _add_scene(turntable)
    turntable.add_argument("-o", "--output", metavar="OUT", required=True, help=_FRAMES)
    turntable.add_argument("--frames", type=whole, default=120, metavar="N", help="cameras around (120)")
    _add_frame(turntable)
    _add_series(turntable)

    compare = command("compare", "Say how far a picture is from another one, or from its scene, and why.")
    compare.add_argument("a", metavar="A", help="picture (or scene) to judge")
    compare.add_argument("b", metavar="B", help="what it should show: a picture, or a scene to render")
    text = "with three or more, A is what all should show"
    compare.add_argument("more", metavar="C", nargs="*", default=[], help=text)
    compare.add_argument("--mask", action="store_true", help="leave edges out, where correct programs differ")
    compare.add_argument("--json", action="store_true", help="print JSON")
    compare.add_argument("--report", metavar="OUT.html", help="write a page with both pictures and figures")
    compare.add_argument("--seconds", type=number, metavar="N", help="longest search for causes (30)")
    compare.add_argument("--spp", type=whole, metavar="N", help="samples per pixel of the scene: 1, 4, 9 ...")
    _add_device(compare)
    compare.add_argument("--threads", type=whole, metavar="N", help="CPU threads")
    _add_limit(compare)

    validate = command("validate", "Let independent programs render scenes, and compare; or judge a program.")
    validate.add_argument("scenes", metavar="SCENE", nargs="*", help="only your own scenes, or shipped ones")
    validate.add_argument("--full", action="store_true", help="every oracle and scene, mutants")
    validate.add_argument("--against", metavar="CMD", help="a program: 'myrt {scene.toml} {out.exr}'")
    validate.add_argument("--as-oracle", action="store_true", help="that program judges clrt, as oracles do")
    validate.add_argument("--timeout", type=number, default=60.0, metavar="S", help="its time a picture (60)")
    validate.add_argument("--report", metavar="OUT.html", help="write a page with all pictures and figures")
    validate.add_argument("--json", action="store_true", help="print JSON, as it stands beside a report")
    validate.add_argument("--random", type=whole, metavar="N", help="scenes drawn at random (0; --full: 100)")
    validate.add_argument("--seed", type=whole, default=1, metavar="S", help="of the random scenes (1)")
    validate.add_argument("--spd", metavar="FOLDER", help="ray counts of balls_c_s4.nff ... in there")
    validate.add_argument("--mutants", action="store_true", help="plant faults: each must be noticed")
    validate.add_argument("--case", action="append", metavar="NAME", help="only this case; may be repeated")
    validate.add_argument("--fresh", action="store_true", help="run all anew, also what is kept")
    validate.add_argument("--list", action="store_true", help="list the cases and what each shows, run none")
    _add_cluster(validate)
    _add_device(validate)

    bench = command("bench", "Time every pass, the tree's builder, and whole pictures.")
    bench.add_argument("--only", type=_names, metavar="A,B", help="kernels, builder, launch, frames ...")
    bench.add_argument("--scene", nargs="+", metavar="SCENE", help="frames of these, not the usual ones")
    _add_limit(bench)
    bench.add_argument("--quick", action="store_true", help="small scenes: a try, not a measurement")
    bench.add_argument("--rounds", type=whole, default=9, metavar="N", help="how often a case is timed (9)")
    bench.add_argument("--against", choices=("embree", "embree-avx2"), help=_AGAINST)
    bench.add_argument("--json", metavar="FILE", help="write all times")
    bench.add_argument("--trace", metavar="FILE.json", help=_TRACE)
    bench.add_argument("--compare", metavar="OLD.json", help="say what is slower or faster than it")
    bench.add_argument("--chart", metavar="FILE", help="draw the roofline chart: .png, .svg or .pdf")
    text = "number or part of a name: `clrt devices`; of two or more, each is timed, and their times compared"
    bench.add_argument("--device", type=device, action="append", default=[], metavar="D", help=text)

    plot = command("plot-spectrum", "Draw a spectrum with its colours, or the matching functions.")
    plot.add_argument(
        "spectrum",
        metavar="NAME",
        help="D65, gold, BK7, patch-1 ..., matching, rgb, metals, glasses, or '{blackbody = 3200}'",
    )
    plot.add_argument("-o", "--output", metavar="OUT", help=".png, .svg or .pdf (NAME.png)")
    plot.add_argument("--bands", type=whole, metavar="N", help="draw what N bands make of it, too")

    devices = command("devices", "List the OpenCL devices; * marks the one that is used.")
    devices.add_argument("--json", action="store_true", help="print JSON")
    doctor = command("doctor", "Say what is wrong with this machine's OpenCL, and the command that mends it.")
    doctor.add_argument("--json", action="store_true", help="print JSON")
    _add_device(doctor)
    scenes = command("scenes", "List the scenes that ship with clrt.")
    scenes.add_argument("--json", action="store_true", help="print JSON")
    selftest = command("selftest", "Check that a device computes what the reference does, bit for bit.")
    selftest.add_argument("--quick", action="store_true", help="without light in bands and generated scenes")
    selftest.add_argument("--only", type=_names, metavar="A,B", help="arithmetic, spheres ...")
    selftest.add_argument("--json", action="store_true", help="print JSON")
    selftest.add_argument("--junit", metavar="F.xml", help="write the results as JUnit XML")
    selftest.add_argument("--bundle", metavar="DIR", help="for what differs: kernel, inputs, a program")
    _add_device(selftest)
    exercising = command("exercise", "Learn: find and mend a fault that is planted in a copy of the kernels.")
    _add_exercises(exercising)
    made.commands = commands.choices
    return made


def _add_exercises(parser: argparse.ArgumentParser) -> None:
    """What can be done with exercises."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    def action(name: str, text: str) -> argparse.ArgumentParser:
        added = actions.add_parser(name, help=text, description=text, allow_abbrev=False)
        unsaid = argparse.SUPPRESS  # what stands before the action's name counts, too
        added.add_argument("-v", "--verbose", action="count", default=unsaid, help="say what is done")
        return added

    action("list", "List the exercises.").add_argument("--json", action="store_true", help="print JSON")
    start = action("start", "Make a folder with kernels that have a fault, scenes and the right picture.")
    start.add_argument("number", metavar="N", type=whole, help="of `clrt exercise list`")
    start.add_argument("folder", metavar="DIR", help="folder to make")
    _add_device(start)
    hint = action("hint", "Give one hint more.")
    hint.add_argument("folder", metavar="DIR", help="folder that `clrt exercise start` made")
    check = action("check", "Say whether the fault is mended; 1 where it is not.")
    check.add_argument("folders", metavar="DIR", nargs="+", help="folders that `clrt exercise start` made")
    check.add_argument("--json", action="store_true", help="print JSON")
    check.add_argument("--into", metavar="FILE", help=argparse.SUPPRESS)  # for processes of our own
    check.add_argument("--timeout", type=number, default=300.0, metavar="S", help="of each of several (300)")
    _add_device(check)


def _add_scene(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help=_SCENE)


def _add_device(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--device", type=device, metavar="D", help="number or part of a name: `clrt devices`")


_SCENE = "scene file, a name from `clrt scenes`, or '-': standard input"
_VIEW = "colours of an 8- or 16-bit picture: 'ACES 2.0 - SDR 100 nits (Rec.709)'"
_AGAINST = "time Embree on the same rays, too; embree-avx2: without AVX-512"
_TRACE = "write when each pass, copy and wait was, for Perfetto"
_FRAMES = ".mp4 .webm .mkv (lossless), or pictures: 'out/{index:03}_{camera.fov}.png'"
_SWEPT = "values at a place: camera.fov=20:60:5 (5 from 20 to 60), materials.glass.ior=1.3,1.5"


def _add_cluster(parser: argparse.ArgumentParser) -> None:
    """Who computes, where that is not this process."""
    parser.add_argument("--cluster", metavar="WHERE", help="local:N workers here, or dask's tcp://HOST:PORT")


def _add_series(parser: argparse.ArgumentParser) -> None:
    """What a series of pictures has beside each of them."""
    _add_cluster(parser)
    parser.add_argument("--manifest", metavar="FILE.csv", help="values, hashes (frames.csv beside them)")
    parser.add_argument("--fps", type=number, default=25.0, metavar="N", help="frames a second (25)")
    parser.add_argument("--exposure", type=number, default=0.0, metavar="EV", help="brighten by EV stops")
    parser.add_argument("--view", metavar="NAME", help=_VIEW)
    parser.add_argument("-q", "--quiet", action="store_true", help="neither progress nor a closing line")


def _add_frame(parser: argparse.ArgumentParser, many: bool = False, crop: bool = True, spp: str = "") -> None:
    """What the picture is, and where it is computed; by default as the scene says. `spp`: what else holds."""
    parser.add_argument("--width", type=whole, metavar="N", help="pixels in a row; alone, keeps the aspect")
    parser.add_argument("--height", type=whole, metavar="N", help="rows of pixels; alone, keeps the aspect")
    if crop:
        sides = ("X", "Y", "W", "H")
        parser.add_argument("--crop", type=whole, nargs=4, metavar=sides, help="only these pixels")
    parser.add_argument("--spp", type=whole, metavar="N", help=f"samples per pixel: 1, 4, 9, 16 ...{spp}")
    text = "up to N samples where neighbours differ: --spp times a power of 4, such as 64"
    parser.add_argument("--adaptive", dest="set", type=_adaptive, action=_Once, default=[], metavar="N",
                        help=text)  # fmt: skip
    parser.add_argument("--max-depth", type=whole, metavar="N", help="generations after the camera's")
    _add_device(parser)
    parser.add_argument("--threads", type=whole, metavar="N", help="CPU threads")
    _add_set(parser, _SWEPT if many else _SET)
    _add_limit(parser)


class _Single(argparse._StoreAction):
    """An option's value; a second one is refused, since the first would be lost without a word."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        if self.option_strings and self.dest in parser.given:
            both = f"{show(parser.given[self.dest])} and {show(values)}"
            raise argparse.ArgumentError(self, f"is given twice, {both}; it takes one value")
        parser.given[self.dest] = values
        super().__call__(parser, namespace, values, option_string)


class _Once(argparse.Action):
    """One (name, value) more; each name once, since of two values the first would be lost without a word."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        given = getattr(namespace, self.dest)
        if values[0] in dict(given):
            raise argparse.ArgumentError(self, f"{show(values[0])} is given twice")
        setattr(namespace, self.dest, [*given, values])


def _add_set(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("--set", type=_setting, action=_Once, default=[], metavar="KEY=VALUE", help=text)


def _add_limit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--limit", type=_limit, action=_Once, default=[], metavar="NAME=N", help=_LIMIT)


def _adaptive(text: str) -> tuple[str, str]:
    """Where in a scene a number of samples stands, and the number; the scene keeps its threshold."""
    return "adaptive.spp", str(whole(text))


def _limit(text: str) -> tuple[str, int]:
    """A limit as `clrt.base.limits.Limits` takes it."""
    from clrt.base.limits import parse

    try:
        return parse(text)
    except ClrtError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


_LIMIT = "what the render may cost at most: depth=99; may be repeated"


def _setting(text: str) -> tuple[str, str]:
    """KEY=VALUE: a place in the scene, and what is to stand there."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise argparse.ArgumentTypeError(f"{show(text)} is not KEY=VALUE, such as camera.fov=30")
    return key.strip(), value.strip()


_SET = "another value at a place of the scene: camera.fov=30, materials.glass.ior=1.4; may be repeated"


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())
