"""The documentation's site: its tutorial runs, its references are whole, its links are looked at."""

from __future__ import annotations

import json
import re
from pathlib import Path

import OpenImageIO as oiio
import pytest

import clrt
from clrt.base.resources import shipped_scenes
from clrt.cli.options import parser
from docs.make_contact_sheet import CAPTION, CELL, GAP
from docs.site import gallery, links, notebooks, pages, reference

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGES = sorted(str(page.relative_to(DOCS).with_suffix("")) for page in DOCS.rglob("*.md")
               if "generated" not in page.parts)  # fmt: skip


def test_the_pages_code_runs_and_gives_the_same_pictures_everywhere() -> None:
    assert notebooks.hashes() == json.loads(notebooks.HASHES.read_text("utf-8"))


def test_the_tutorial_shows_each_of_ten_steps() -> None:
    text = (DOCS / "tutorial.md").read_text("utf-8")
    assert len(re.findall(r"^## \d+\. ", text, re.M)) == 10 == len(re.findall("^```python", text, re.M))
    shown = re.findall(r"tutorial/(\w+)\.png", pages.prepared("tutorial", text))
    kept = json.loads(notebooks.HASHES.read_text("utf-8"))
    assert len(shown) == 10 and len({kept[f"tutorial: {name}.png"] for name in shown}) == 10


def test_a_notebook_has_the_page_s_code_and_what_it_gives(tmp_path: Path) -> None:
    made = notebooks.notebook("concepts/queues", tmp_path)
    kinds = [cell["cell_type"] for cell in made["cells"]]
    assert kinds == ["markdown", "code", "markdown"] and made["nbformat"] == 4
    code = "".join(made["cells"][1]["source"])
    assert code in (DOCS / "concepts" / "queues.md").read_text("utf-8") and "](" not in str(made)
    assert set(notebooks.PAGES) == {
        name for name in PAGES if name.startswith(("tutorial", "concepts/", "colour"))
        and "```python" in (DOCS / f"{name}.md").read_text("utf-8")
    }  # fmt: skip


@pytest.mark.parametrize("name", PAGES)
def test_no_page_leads_out_of_the_site(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for file in ("figures/generations.svg", "figures/scan.svg", "figures/media.png", "figures/glasses.svg",
                 "figures/rainbow.png", "figures/observer.svg", "wavefront.txt", "bits.txt"):  # fmt: skip
        (tmp_path / "generated" / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "generated" / file).write_text("made")
    text = (DOCS / name).with_suffix(".md").read_text("utf-8")
    made = re.search(r"<!-- (figure|table|code): ", text) is not None
    if made:
        monkeypatch.setattr(pages, "DOCS", tmp_path)
    prepared = pages.prepared(name, text)
    outside = [target for target in re.findall(r"\]\(([^)#]+)", prepared)
               if target.startswith("..") and not made
               and not (DOCS / name).parent.joinpath(target).resolve().is_relative_to(DOCS)]  # fmt: skip
    assert outside == [] and "<!-- figure: " not in prepared and "<!-- others" not in prepared


def test_a_link_out_becomes_the_file_s_name() -> None:
    both = "[reading.py](../validation/oracle_mitsuba/reading.py), [it](../README.md)"
    said = pages.prepared("validation", both)
    assert said == "`validation/oracle_mitsuba/reading.py`, it (`README.md`)"
    with pytest.raises(SystemExit, match=r"docs/api\.md: \.\./none is not there"):
        pages.prepared("api", "[a](../none)")


def test_every_page_is_in_the_index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = pages.prepared("index", (DOCS / "index.md").read_text("utf-8"))
    listed = {line.split("<")[-1].rstrip(">") for line in text.splitlines()}
    assert {name for name in PAGES if not name.startswith("site/")} <= listed | {"index"}
    # what nobody has placed stands with the pages on how clrt is made, which one for users is not
    assert pages.others() == []
    (tmp_path / "index.md").write_text("```{toctree}\nfirst\nSecond <second>\n<!-- others -->\n```\n")
    for name in ("first", "second", "third"):
        (tmp_path / f"{name}.md").write_text("# A page\n")
    monkeypatch.setattr(pages, "DOCS", tmp_path)
    assert pages.others() == ["third"]


def test_the_references_are_whole() -> None:
    page = reference.commands()
    for name, command in parser().commands.items():
        part = page.split(f"\n## clrt {name}\n")[1].split("\n## ")[0]
        for action in command._actions:
            options = set(action.option_strings) - {"-h", "--help"}
            assert not options or all(option in part for option in options), (name, options)
    assert "### clrt exercise check" in page and "`--timeout S`" in page
    for name in set(clrt.__all__) - {"__version__"}:
        assert re.search(rf"^\.\. auto\w+:: clrt\.{name}$", reference.python(), re.M)


def test_types_are_plain() -> None:
    meta = "msgspec.Meta(gt=0, description='must be a length > 0')"
    assert reference.plain_type(f"Annotated[float, {meta}]") == "float, must be a length > 0"
    triple = 'Annotated[tuple[float, float], msgspec.Meta(description="of \'a\'")] | None'
    assert reference.plain_type(triple) == "tuple[float, float], of 'a' | None"
    assert reference.plain_type("int | None") == "int | None"


def test_the_gallery_has_every_scene(tmp_path: Path) -> None:
    assert set(gallery.names()) == set(shipped_scenes())
    sheet = oiio.ImageBuf(str(DOCS / "contact-sheet.png")).spec()
    rows = -(-len(gallery.names()) // 5)
    assert (sheet.width, sheet.height) == (5 * (CELL[0] + GAP) + GAP, rows * (CELL[1] + CAPTION + GAP) + GAP)
    gallery.write(tmp_path)
    page = (tmp_path / "gallery.md").read_text("utf-8")
    for name in gallery.names():
        assert f"\n## {name}\n" in page
        assert clrt.read_image(tmp_path / "gallery" / f"{name}.png").shape == (CELL[1], CELL[0], 3)


def test_dead_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<h1 id="here"></h1><a href="#here"></a><a href="b.html#there"></a><a href="https://example.org/"></a>'
        '<img src="data:image/png;base64,AA"><a href="sub/">'
    )
    (tmp_path / "b.html").write_text('<p id="there"><a href="a.html">')
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "index.html").write_text('<a href="../a.html#here">')
    assert links.main(tmp_path) == 0
    (tmp_path / "c.html").write_text(
        '<a href="none.html"></a><a href="a.html#none"></a><script src="https://example.org/x.js"></script>'
    )
    assert links.faults(tmp_path) == [
        "c.html: loads https://example.org/x.js", "c.html: none.html is not there",
        "c.html: a.html#none has no such place",
    ]  # fmt: skip
    assert links.main(tmp_path) == 1
