"""The suite's page: what stands in it, without a browser."""

from __future__ import annotations

import base64
import dataclasses
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import report_samples as samples
from clrt.base.errors import ClrtError
from clrt.base.resources import validation_module
from clrt.cli import main
from clrt.images.file import encode

report = validation_module("suite.report")
pictures = validation_module("suite.pictures")
types = validation_module("types")
VOID = {"meta", "link", "input", "br"}


class Page(HTMLParser):
    """The page's elements; complains of ends that do not fit."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.starts: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.starts.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, (tag, self.getpos())

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.text.append(data)

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


def page(result: Any) -> Page:
    return Page(report.report_html(result))


def test_the_page_of_a_good_run_says_so():
    result = samples.result(wrong=False)
    assert result.passed
    words = page(result).words
    assert "✓ Proven: independent programs compute the same pictures" in words
    for said in (
        "2 of 2 agree with every oracle",
        "2 of 2 features proven",
        "1 of 1 planted faults were caught",
        "clrt validate --full --random 3 --seed 7",
        "random scenes of seed 7",
        "PoCL 3.0 / a CPU",
        "4 min 14 s",
        "Every comparison that was asked for was made",
        "263100",
        "-0.026 %",
        "m + 1 for m",
        "mitsuba 3.9.1",
    ):
        assert said in words, said
    assert "✗" not in words and "What failed" not in words


def test_the_page_of_a_run_without_flip():
    found = samples.without_flip(samples.result(wrong=False))
    words = page(found).words
    assert "✓ Proven" in words and "FLIP was not run" in words and "not a number" not in words
    data = pictures.case_pictures(found.cases[0].ours, found.cases[0].results)
    assert set(data["oracles"]["oracle64"]) == {"reference", "difference", "ssim", "mask"}


def test_the_page_of_a_bad_run_says_what_failed_and_where():
    result = samples.result(wrong=True)
    words = page(result).words
    said = "2 comparisons failed, 1 comparison not made, 1 feature too thinly covered, 1 mutant survived"
    assert f"✗ Not proven: {said}" in words
    assert "glass of another index , oracle64: generation 2, transmission" in words
    assert "✗ 1 comparison could not be made" in words and "LLVM is missing" in words
    assert "mitsuba-table: not run" in words and "SURVIVED" in words and "Too few: fresnel." in words


@pytest.mark.parametrize(("changes", "says"), [
    ({"coverage": {"a": {"x"}, "b": set()}}, "Not proven: 2 features too thinly covered"),
    ({"counts": [types.CountResult("s", "k", 2, 1, 1.0)]}, "Not proven: 1 ray count off"),
    ({"mutants": [types.MutantResult("m", "f", "d", (), True)] * 2}, "Not proven: 2 mutants survived"),
    ({"checks": (types.CheckResult("float32 twin", False, "1 bit", 1.0),)}, "Not proven: 1 check failed"),
])  # fmt: skip
def test_each_part_can_spoil_the_headline(changes: dict[str, Any], says: str):
    result = dataclasses.replace(samples.result(wrong=False), **changes)
    assert report.headline(result) == says and not result.passed


def test_a_case_without_an_oracle_has_proved_nothing():
    good = samples.result(wrong=False)
    lonely = dataclasses.replace(good.cases[0], results={}, unproven={"oracle64": "it broke"})
    result = dataclasses.replace(good, cases=[lonely])
    assert report.headline(result) == "Not proven: 1 comparison failed, 1 comparison not made"
    assert "all is well , no oracle ran" in page(result).words


def test_an_empty_run_makes_a_page():
    nothing = types.SuiteResult([], [], [], {}, {}, "none", 0.0, None)
    words = page(nothing).words
    assert words.count("not run in this run") == 6 and "0 of 0 cases" not in words


def test_the_page_needs_nothing_but_itself():
    text = report.report_html(samples.result())
    assert not re.search(r"https?://", text) and "<script src" not in text and "@import" not in text
    assert "default-src 'none'" in text
    for tag, attributes in Page(text).starts:
        for name in ("src", "href"):
            assert (attributes.get(name) or "#").startswith(("#", "data:")), (tag, attributes)


def test_every_link_within_the_page_has_its_place():
    starts = page(samples.result()).starts
    places = [attributes["id"] for _, attributes in starts if "id" in attributes]
    links = {attributes["href"] for tag, attributes in starts if tag == "a"}
    assert len(places) == len(set(places)) and {f"#{place}" for place in places} >= links
    sections = ("mutants", "coverage", "closest", "unproven", "counts", "checks", "cases", "case-2")
    assert {f"#{name}" for name in sections} <= links


def test_texts_are_no_markup():
    bad = '</script><script>alert("x")</script>&<i>'
    good = samples.result(wrong=False)
    named = dataclasses.replace(
        good.cases[0], case=dataclasses.replace(good.cases[0].case, name=bad, note=bad)
    )
    mutant = types.MutantResult(bad, bad, bad, (bad,), False, bad)
    hostile = page(
        dataclasses.replace(good, cases=[named], mutants=[mutant], device=bad, command=bad, notes=(bad,))
    )
    assert sum(tag == "script" for tag, _ in hostile.starts) == 5, "data, scale and the scripts of the page"
    assert hostile.words.count('alert("x")') > 8
    assert "</script" not in report.script_data({"a": "</script>"})


def test_the_file_is_whole_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = report.write_report(samples.result(), tmp_path / "report.html")
    assert path == (tmp_path / "report.html").resolve() and path.read_text("utf-8").startswith(
        "<!doctype html>"
    )
    with pytest.raises(ClrtError):
        report.write_report(samples.result(), tmp_path / "no" / "report.html")
    monkeypatch.setattr(report, "report_html", lambda result: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        report.write_report(samples.result(), tmp_path / "other.html")
    assert [file.name for file in tmp_path.iterdir()] == ["report.html"]


def test_pages_stay_small():
    """100 cases of 192 x 144 pixels under three oracles must fit into 40 MB; noise compresses worst."""
    noisy = np.random.default_rng(0).random((144, 192, 3))
    maps = {
        "difference": noisy - 0.5,
        "flip": noisy[..., 0],
        "ssim": noisy[..., 1],
        "mask": noisy[..., 2] > 0.9,
    }
    oracle = types.OracleImage(noisy, {}, None, None, "o", 1.0)
    data = pictures.case_pictures(oracle, {"o": (oracle, types.Comparison({}, (), maps))})
    assert len(json.dumps(data)) < 350_000
    real = pictures.case_pictures(samples.result().cases[0].ours, samples.result().cases[0].results)
    assert len(json.dumps(real)) < 60_000


# --- pictures and maps


def decoded(text: str) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(text))))


def test_the_reference_comes_back_exactly():
    case = samples.result().cases[2]
    data = pictures.case_pictures(case.ours, case.results)
    assert (data["width"], data["height"], set(data["oracles"])) == (160, 120, {"oracle64", "mitsuba-table"})
    ours = decoded(data["ours"])
    assert np.array_equal(ours, encode(case.ours.pixels))
    image, found = case.results["oracle64"]
    stored = data["oracles"]["oracle64"]
    assert np.array_equal(ours ^ decoded(stored["reference"]), encode(image.pixels.astype(np.float32)))
    assert np.array_equal(decoded(stored["mask"]) > 0, found.maps["mask"] > 0)
    assert np.abs((decoded(stored["flip"]) / 255) ** 2 - found.maps["flip"]).max() < 0.004
    assert np.abs(1 - (decoded(stored["ssim"]) / 255) ** 2 - np.clip(found.maps["ssim"], 0, 1)).max() < 0.004


def test_differences_are_told_to_some_percent_with_their_sign():
    sizes = np.geomspace(1e-5, 3, 500)
    for sign in (1, -1):
        level = pictures.signed_bytes(sign * sizes).astype(int) - 128
        back = np.sign(level) * pictures.FLOOR * 10 ** (pictures.DECADES * (np.abs(level) - 1) / 126)
        assert np.abs(back / (sign * sizes) - 1).max() < 0.055
    assert pictures.signed_bytes(np.array([0, 9e-6, -9e-6, 1e9, -1e9, np.nan])).tolist() == [
        128,
        128,
        128,
        255,
        1,
        255,
    ]


def test_pictures_that_were_not_kept_or_do_not_fit_have_no_viewer():
    case = samples.result(wrong=False).cases[0]
    empty = dataclasses.replace(case.ours, pixels=np.zeros((0, 0, 3)))
    assert pictures.case_pictures(empty, case.results) == {}
    image, found = case.results["oracle64"]
    small = dataclasses.replace(image, pixels=image.pixels[:50])
    assert pictures.case_pictures(case.ours, {"oracle64": (small, found)})["oracles"] == {}
    bare = dataclasses.replace(found, maps={})
    lean = dataclasses.replace(case, ours=empty, results={"oracle64": (image, bare)})
    result = dataclasses.replace(samples.result(wrong=False), cases=[lean])
    assert not any(attributes.get("class") == "viewer" for _, attributes in page(result).starts)


# --- figures


@pytest.mark.parametrize(("value", "text"), [
    (0.0, "0"), (1.0, "1"), (0.998, "0.998"), (0.9999, "0.9999"), (0.9999991, "0.9999991"),
    (1 - 1e-12, "1"), (0.5, "0.5"),
    (1.234e-7, "1.2e-07"), (0.00204, "0.00204"), (45.06, "45.1"), (263169.0, "263169"), (float("inf"), "∞"),
    (float("nan"), "not a number"), (-0.5, "-0.5"), (3.14159, "3.142"),
])  # fmt: skip
def test_figures_read_well(value: float, text: str):
    assert report.figure(value) == text


def test_durations_read_well():
    assert [report.duration(s) for s in (0.25, 12.4, 99.4, 254, 3600)] == [
        "0.25 s",
        "12 s",
        "99 s",
        "4 min 14 s",
        "60 min 0 s",
    ]


def test_the_closest_figures_are_the_worst_of_each_gate():
    gate = validation_module("compare.oracle").gate

    def case(name: str, **values: float) -> Any:
        gates = (gate("SSIM", values["ssim"], 0.998, "high"), gate("FLIP", values["flip"], 0.002, "low"),
                 gate("generation 1, reflection", values["ray"], 0.999, "high"))  # fmt: skip
        image = types.OracleImage(np.zeros((0, 0, 3)), {}, None, None, "o", 1.0)
        about = types.Case(name, {}, frozenset(), ("o",), 1, 1)
        return types.CaseResult(about, image, {"o": (image, types.Comparison({}, gates, {}))})

    cases = [case("a", ssim=0.9999, flip=0.001, ray=1.0), case("b", ssim=0.9985, flip=0.0, ray=0.9995),
             case("c", ssim=0.999, flip=float("nan"), ray=0.9999)]  # fmt: skip
    result = types.SuiteResult(cases, [], [], {}, {}, "", 0.0, None)
    found = {gate.name: (name, gate.passed) for gate, name, _ in report.closest(result)}
    assert found == {"SSIM": ("b", True), "FLIP": ("c", False), "generation 1, reflection": ("b", True)}


def test_a_run_of_some_cases_says_of_how_many():
    result = dataclasses.replace(samples.result(wrong=False), known=137)
    says = "Proven for 2 of 137 cases: independent programs compute the same pictures"
    assert report.headline(result) == says
    whole = dataclasses.replace(result, known=2)
    assert report.headline(whole) == "Proven: independent programs compute the same pictures"


def test_the_command_answers_programs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(validation_module("suite.run"), "run", lambda *_: samples.result())
    page = tmp_path / "out.html"
    assert main(["validate", "--json", "--report", str(page)]) == 1
    found, beside = json.loads(capsys.readouterr().out), json.loads(page.with_suffix(".json").read_text())
    assert found == beside and found["passed"] is False and found["cases"]
