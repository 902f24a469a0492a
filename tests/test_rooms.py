"""The folders of `clrt` stand one on the other, as docs/design.md lists them: imports go one way."""

from __future__ import annotations

import ast
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = (
    "base", "layout", "images", "spectra", "meshfiles", "scene", "formats", "flatten", "raytree", "device",
    "engine", "cluster", "judging", "diagnosis", "bench", "exercises", "view", "cli",
)  # fmt: skip
"""From the ground up."""
# Files of a room that name each other, one of them for types alone. Each is a part of a class or of a job,
# in a file of its own, whose functions take the whole: nothing of the whole is needed to import it.
PARTS = {
    "clrt.engine.adaptive": "clrt.engine.job",
    "clrt.engine.shown": "clrt.engine.tracer",
    "clrt.formats.mitsuba.spectra": "clrt.formats.mitsuba.values",
    "clrt.images.dataset": "clrt.images.image",
    "clrt.raytree.document": "clrt.raytree.tree",
    "clrt.raytree.drawing": "clrt.raytree.tree",
    "clrt.raytree.files": "clrt.raytree.tree",
    "clrt.raytree.page": "clrt.raytree.tree",
    "clrt.raytree.sums": "clrt.raytree.tree",
    "clrt.raytree.tubes": "clrt.raytree.tree",
    "clrt.raytree.ways": "clrt.raytree.tree",
    "clrt.raytree.words": "clrt.raytree.tree",
    "clrt.scene.advice": "clrt.scene.scene",
    "clrt.scene.changes": "clrt.scene.scene",
    "clrt.scene.save": "clrt.scene.scene",
    "clrt.scene.summary": "clrt.scene.scene",
    "clrt.scene.unfiled": "clrt.scene.scene",
    "clrt.spectra.colorimetry": "clrt.spectra.bands",
}
# Where the command line and the diagnosis reach what is above them, within a function: it may be missing.
VALIDATION = {
    "clrt/base/resources.py", "clrt/cli/compare.py", "clrt/cli/convert.py", "clrt/cli/judging.py",
    "clrt/cli/selftest.py", "clrt/cli/validate.py", "clrt/cli/validate_against.py", "clrt/cli/validating.py",
    "clrt/cluster/calls.py", "clrt/cluster/worker.py", "clrt/diagnosis/doctor.py", "clrt/diagnosis/probe.py",
    "clrt/judging/verdict.py",
}  # fmt: skip


def modules(root: Path, package: str = "clrt") -> dict[str, Path]:
    found = {}
    for path in sorted((root / package).rglob("*.py")):
        name = ".".join(path.relative_to(root).with_suffix("").parts)
        found[name.removesuffix(".__init__")] = path
    return found


def typing_only(tree: ast.Module) -> set[ast.AST]:
    blocks = [node for node in ast.walk(tree) if isinstance(node, ast.If)]
    guarded = [node for node in blocks if "TYPE_CHECKING" in ast.unparse(node.test)]
    return {inner for node in guarded for statement in node.body for inner in ast.walk(statement)}


def imported(path: Path, known: dict[str, Path]) -> Iterator[tuple[str, bool]]:
    """Each module of clrt that a file imports, wherever in it, and whether that is for types alone."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    guarded = typing_only(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            raise AssertionError(f"{path}: imports within clrt are written out: {ast.unparse(node)}")
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "clrt":
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield inner if inner in known else str(node.module), node in guarded
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "clrt":
                    yield alias.name, node in guarded


def room(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else ""


def climbing(root: Path) -> list[str]:
    """What imports from a room above its own, for types alone or not."""
    known = modules(root)
    return [
        f"{name} imports {target}"
        for name, path in known.items() if room(name) in ROOMS
        for target, _ in imported(path, known)
        if room(target) in ROOMS and ROOMS.index(room(target)) > ROOMS.index(room(name))
    ]  # fmt: skip


def reached(graph: dict[str, set[str]], start: str) -> set[str]:
    seen: set[str] = set()
    todo = list(graph.get(start, ()))
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += graph.get(module, ())
    return seen


def circles(root: Path) -> list[str]:
    """Files that import each other, one after the other, but for types alone."""
    known = modules(root)
    graph = {
        name: {target for target, types in imported(path, known) if not types and target != "clrt"}
        for name, path in known.items()
    }
    return [name for name in graph if name in reached(graph, name)]


def parts(root: Path) -> dict[str, str]:
    """What a file imports for types alone that imports it, at once or by way of others."""
    known = modules(root)
    found = {name: list(imported(path, known)) for name, path in known.items() if room(name) in ROOMS}
    graph = {name: {target for target, _ in targets} for name, targets in found.items()}
    return {
        name: target
        for name, targets in found.items()
        for target, types in targets if types and name in reached(graph, target)
    }  # fmt: skip


def round_about(root: Path) -> list[str]:
    """The rooms of validation, its folders and the files beside them, that import each other in a circle."""
    known = modules(root, "validation")
    graph: dict[str, set[str]] = {room(name): set() for name in known}
    for name, path in known.items():
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                above = package.split(".")[: 1 - node.level or None] + (node.module or "").split(".")
                base = ".".join(filter(None, above))
                targets = [f"{base}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Call) and ast.unparse(node.func) == "validation_module":
                targets = [f"validation.{ast.literal_eval(node.args[0])}"] if node.args else []
            else:
                continue
            graph[room(name)] |= {room(target) for target in targets} & graph.keys() - {room(name)}
    return sorted(name for name in graph if name in reached(graph, name))


def test_every_file_is_in_a_room() -> None:
    apart = {name for name in modules(ROOT) if room(name) not in ROOMS}
    assert apart == {"clrt", "clrt.__main__", "clrt.version"}
    assert [name for name in ROOMS if not list((ROOT / "tests" / name).glob("test_*.py"))] == []


def test_a_relative_import_is_seen(tmp_path: Path) -> None:
    (tmp_path / "odd.py").write_text("from ..scene.scene import Scene\n")
    with pytest.raises(AssertionError, match="written out"):
        list(imported(tmp_path / "odd.py", {}))


def test_imports_go_down() -> None:
    assert climbing(ROOT) == []


def test_no_files_import_each_other() -> None:
    assert circles(ROOT) == []


def test_no_rooms_of_validation_import_each_other(tmp_path: Path) -> None:
    assert round_about(ROOT) == []
    shutil.copytree(ROOT / "validation", tmp_path / "validation")
    for more in ("from ..mutants import run", "from .. import mutants", "validation_module('mutants.run')"):
        (tmp_path / "validation" / "oracle64" / "odd.py").write_text(f"def odd():\n    {more}\n")
        assert {"mutants", "oracle64", "oracles"} <= set(round_about(tmp_path)), more


def test_only_parts_of_a_whole_name_it_for_types() -> None:
    assert parts(ROOT) == PARTS


@pytest.mark.parametrize("find", [climbing, circles])
def test_a_step_up_is_seen(find: object, tmp_path: Path) -> None:
    """Planted: a limit that asks the scene, which asks the limits."""
    for name, path in modules(ROOT).items():
        copy = tmp_path / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        more = "\ndef odd():\n    from clrt.scene.scene import Scene\n" if name == "clrt.base.limits" else ""
        copy.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    assert any("clrt.base.limits" in found for found in find(tmp_path))  # type: ignore[operator]


def test_only_named_places_reach_validation() -> None:
    pattern = re.compile(r"validation_module\(|clrt_validation|from validation|import validation")
    files = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in modules(ROOT).values()}
    found = {name for name, text in files.items() if pattern.search(text)}
    assert found == VALIDATION
    for path in (ROOT / name for name in VALIDATION):
        outside = [node for node in ast.parse(path.read_text()).body if not isinstance(node, ast.FunctionDef)]
        called = [node for top in outside for node in ast.walk(top) if isinstance(node, ast.Call)]
        assert not any("validation_module" in ast.unparse(node.func) for node in called), path


def test_the_map_is_that_of_the_code() -> None:
    """docs/design.md lists the rooms in this order, and every file that it names is there."""
    page = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `clrt/(\w+)/` \|", page, re.M)
    assert listed == list(ROOMS)
    named = set(re.findall(r"`((?:clrt|kernels|validation|tests)/[\w./-]+\.\w+)`", page))
    assert len(named) > 30
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []
    places = re.findall(r"^\| .* \| .*?`((?:clrt|kernels)/[\w./]+)`, ((?:`[\w.]+`(?: and )?)+)", page, re.M)
    assert len(places) >= 5
    for file, names in places:
        text = (ROOT / file).read_text(encoding="utf-8")
        for name in re.findall(r"\w+(?=`)", names):
            assert re.search(rf"(def|void|floatP) {name}\(", text), f"{file} has no {name}"
