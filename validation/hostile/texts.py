"""Texts that are small and mean much: dotted keys, nesting, the same name or entry many times, long words."""

from __future__ import annotations

import copy
import random
from typing import Any, Final

from ..scenes.parts import Table
from .sizes import count

_LENGTHS: Final = (100, 1000, 3000, 10_000, 20_000)


def toml(draw: random.Random) -> bytes:
    """One construct of TOML at length, beside nothing else."""
    n = draw.choice(_LENGTHS)
    choices: tuple[Any, ...] = (
        lambda: "a." * n + "b = 1",
        lambda: "[" + "a." * n + "b]",
        lambda: "[[" + ".".join(["a"] * min(n, 3000)) + "]]\n" * 2,
        lambda: "a = " + "{a = " * n + "1" + "}" * n,
        lambda: "a = " + "[" * n + "]" * n,
        lambda: "\n".join(f"[a.b{k}]" for k in range(n)),
        lambda: "\n".join(f"a.b{k}.c = 1" for k in range(n)),
        lambda: "\n".join(f"a{k} = 1" for k in range(n)) + "\na0 = 1",
        lambda: "[[shapes]]\n" * n,
        lambda: "a = " + "9" * n,
        lambda: "a = 1e" + "9" * n,
        lambda: 'a = "' + "\\u202e" * n + '"',
        lambda: '"' + "\\u001b[31m" * n + '" = 1',
        lambda: "a = '''" + "'" * n,
        lambda: "#" * n * 10,
        lambda: "a = " + "1, " * n,
        lambda: "a = 2026-01-01T00:00:00." + "9" * n,
        lambda: '"' + "a" * n * 50 + '" = 1\n' * 2,
    )
    return str(draw.choice(choices)()).encode()


def json(draw: random.Random) -> bytes:
    """One construct of JSON at length."""
    n = draw.choice(_LENGTHS)
    choices: tuple[Any, ...] = (
        lambda: "[" * n + "]" * n,
        lambda: '{"a":' * n + "1" + "}" * n,
        lambda: "{" + ",".join(f'"a{k}":1' for k in range(n)) + ',"a0":1}',
        lambda: '{"materials":{' + ",".join(f'"m{k}":{{}}' for k in range(n)) + ',"m0":{}}}',
        lambda: (
            '{"materials":{' + ",".join(f'"m{k}":{{}}' for k in range(n)) + '},"shapes":[{"type":"sphere",'
            '"center":[0,0,0],"radius":1,"material":"x1"}]}'
        ),
        lambda: '{"' + "x" * n * 50 + '":1}',
        lambda: '{"max_depth":' + "9" * n + "}",
        lambda: '{"max_depth":1e' + "9" * n + "}",
        lambda: '{"shapes":[' + ",".join(["{}"] * n) + "]}",
        lambda: '{"shapes":[' + ",".join(['{"type":"' + "spheer" * 20 + '"}'] * n) + "]}",
        lambda: '{"lights":' + "[[]," * n + "[]" + "]" * n + "}",
        lambda: '"' + "\\ud800" * n + '"',
    )
    return str(draw.choice(choices)()).encode()


def lines(draw: random.Random, text: str) -> bytes:
    """A text of lines (NFF, thesis) with a line, or a word of it, many times, or each time another."""
    found = text.splitlines()
    at = draw.randrange(len(found))
    many, choice = count(draw, len(found[at])), draw.random()
    if choice < 0.4:
        found[at:at] = [found[at]] * many
    elif choice < 0.7:  # fills, surfaces and places that are never equal
        head, *rest = [*found[at].split(" "), ""]
        found[at:at] = [" ".join([head, f"0.{k}", *rest[1:]]).strip() for k in range(many)]
    elif choice < 0.85:
        word = draw.choice(found[at].split(" "))
        found[at] = " ".join([found[at], *[word] * many])
    else:
        found[at] += draw.choice("9x-\x1b") * draw.choice((400, 10**6))
    return "\n".join(found).encode()


def repeat(draw: random.Random, table: Table) -> Table:
    """A scene with one of its entries many times: shapes, lights, materials, names, points of an outline."""
    table, many = copy.deepcopy(table), count(draw)
    kind = draw.choice(("shapes", "shapes", "moved", "lights", "materials", "names", "transform", "points"))
    shape = draw.choice(table["shapes"])
    if kind == "shapes":
        table["shapes"] = [*table["shapes"], *[shape] * many]
    elif kind == "moved":
        table["shapes"] += [
            {**shape, "transform": [{"translate": [k % 99, k // 99, 0]}]} for k in range(many)
        ]
    elif kind == "lights" and table.get("lights"):
        table["lights"] = table["lights"] + [draw.choice(table["lights"])] * many
    elif kind == "names":
        table["shapes"] = [{**shape, "material": f"m{k}"} for k in range(many)]
        table["materials"] = {f"m{k}": {"diffuse": k / many} for k in range(many - draw.choice((0, 1)))}
    elif kind == "transform":
        table["shapes"] = [{**shape, "transform": [{"rotate": [[0, 1, 0], 0.1]}] * many}]
    elif kind == "points":
        ring = [[k / many, (k * k % 7) * draw.choice((0, 1)), 0] for k in range(many)]
        table["shapes"] = [{"type": "polygon", "points": ring}]
    else:
        made = {f"x{k}": {"diffuse": k / many} for k in range(many)}
        table["materials"] = {**table.get("materials", {}), **made}
    return table
