"""`clrt explain`: where a pixel's light comes from, as a tree of its rays."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any, Final

from clrt.base.errors import ClrtError
from clrt.cli.outputs import check_apart
from clrt.cli.source import read, scene_path
from clrt.cli.terminal import console, marked

if TYPE_CHECKING:
    from clrt.raytree.tree import Ray, RayTree

_ENDLESS: Final = 1 << 16


def run(options: argparse.Namespace) -> int:
    """Print the tree, or JSON, or write files. ClrtError, before rendering, where one cannot be written."""
    import clrt
    from clrt.formats.native import with_values
    from clrt.raytree.files import check

    file = scene_path(options.scene)
    if not 0 <= options.least <= 100:
        raise ClrtError(f"--least: {options.least} is not allowed; it must be from 0 to 100 percent")
    outputs = {f"-o ({name})" if number else "-o": name for number, name in enumerate(options.output)}
    check_apart(outputs, {"the scene": file})
    for name in options.output:
        check(name)
    limits = clrt.Limits(**dict(options.limit))
    scene = with_values(read(file, limits), options.set)
    check_apart(outputs, {})
    settings = clrt.Settings(threads=options.threads, limits=limits)
    picture = options.width, options.height, options.spp, options.max_depth
    with clrt.Tracer(scene, options.device, settings) as tracer:
        tree = tracer.explain(options.x, options.y, *picture)
    for name in options.output:
        tree.save(name)
    if options.json:
        print(tree.to_json())
    elif not options.quiet and not options.output:
        # for a file or a program lines are as long as they are
        width = None if sys.stdout.isatty() else _ENDLESS
        console(width=width, highlight=False).print(shown(tree, options.least / 100))
    elif not options.quiet:
        from clrt.raytree.words import summary, title

        print(f"{', '.join(options.output)}: {title(tree)}; {summary(tree)}")
    return 0


def shown(tree: RayTree, least: float) -> Any:
    """The tree as rich prints it, without branches that bring less than the part `least` of the pixel."""
    from rich.tree import Tree

    from clrt.raytree.words import summary, title

    top = Tree(f"[bold]{marked(title(tree))}[/]; {marked(summary(tree))}", guide_style="dim")
    todo = [(root, top) for root in reversed(tree.roots)]
    while todo:
        ray, above = todo.pop()
        own = _branch(tree, ray, above, least)
        kept = [child for child in ray.children if tree.branch_shares[child.number] >= least]
        cut = [child for child in ray.children if tree.branch_shares[child.number] < least]
        if cut:
            share = sum(tree.branch_shares[child.number] for child in cut)
            own.add(f"[dim]{_more(len(cut), share)}[/]")
        todo += [(child, own) for child in reversed(kept)]
    return top


def _branch(tree: RayTree, ray: Ray, above: Any, least: float) -> Any:
    from clrt.raytree.words import heading, lines, percent

    colour = {"camera": "bold", "reflection": "red", "transmission": "blue", "ambient": "magenta"}[ray.kind]
    share = percent(tree.branch_shares[ray.number])
    own = above.add(f"[bold]{share}[/] [{colour}]{marked(heading(tree, ray))}[/]")
    for line in lines(tree, ray):
        if line.colour:
            if line.share >= least:
                own.add(f"{percent(line.share)} {marked(line.text)}: {marked(line.colour)}")
        elif line.why or not least:
            own.add(f"[dim]{marked(line.text)}[/]")
    return own


def _more(count: int, share: float) -> str:
    from clrt.raytree.words import percent

    rays = f"{count} more rays and what they spawn" if count > 1 else "1 more ray and what it spawns"
    return f"{rays}: {percent(share)} (--least 0 shows all)"
