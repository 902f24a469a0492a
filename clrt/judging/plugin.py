"""A pytest plugin: the fixture `same_picture` judges a test's picture by one that is kept beside the test.

pytest loads this module in every run, so it imports nothing else of clrt until a picture is judged.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pytest

if TYPE_CHECKING:
    from clrt.judging.verdict import Verdict

FOLDER: Final = "pictures"  # beside the test's file: a folder for each of them
REPORTS: Final = "picture-reports"  # beside pytest's configuration
_UPDATED: Final = "picture updated"
_KINDS: Final = (".exr", ".png")  # floats, 8 bits


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("pictures", "reference pictures (clrt)")
    group.addoption("--update-pictures", action="store_true", default=False,
                    help="keep what tests render as the new reference pictures of `same_picture`")
    group.addoption("--picture-reports", metavar="FOLDER", default=None,
                    help=f"where reports on pictures that differ are written ({REPORTS})")  # fmt: skip


@pytest.fixture
def same_picture(request: pytest.FixtureRequest) -> SamePicture:
    """Call it with a picture: the test fails where that is not its reference picture."""
    return SamePicture(request)


class SamePicture:
    """Judges the pictures of one test."""

    def __init__(self, request: pytest.FixtureRequest) -> None:
        self._config = request.config
        self._node = request.node
        self._used: set[str] = set()

    def __call__(
        self, picture: Any, name: str = "", *, gates: Mapping[str, float] | None = None, mask: bool = False,
        scene: Any = None,
    ) -> Verdict:
        """Fail the test where `picture` is not the one that is kept for it; return the verdict.

        picture: what `clrt.compare` takes. name: tells several pictures of one test apart. gates, mask: as
        for `clrt.compare`. scene: what the picture should show, as clrt reads it; on failure its lights,
        materials and so on are searched for the cause.
        """
        __tracebackhide__ = True
        import numpy as np

        import clrt
        from clrt.judging.verdict import as_pixels

        stem, pixels = self._stem(name), as_pixels("picture", picture)
        if not np.isfinite(pixels).all():
            pytest.fail(f"{stem}: the picture has pixels that are NaN or infinite")
        folder = Path(self._node.path).parent / FOLDER / Path(self._node.path).stem
        kept = next((folder / (stem + kind) for kind in _KINDS if (folder / (stem + kind)).exists()), None)
        updating = self._config.getoption("--update-pictures")
        try:
            verdict = None
            if kept is not None:  # its pixels: a .png was kept as it holds all there was, so none is clipped
                verdict = clrt.compare(pixels, as_pixels("kept", kept), gates, mask=mask)
                verdict = replace(verdict, names=("picture", str(kept)))
        except clrt.ClrtError:  # it is damaged, perhaps
            if not updating:
                raise
            verdict = None
        report = self._report(stem)
        if updating or (verdict and verdict.passed):
            shown = report.with_suffix("").name  # where there was no reference picture
            for left in (report, *(report.with_name(shown + kind) for kind in _KINDS)):
                with suppress(OSError):  # no folder of reports can be there
                    left.unlink()  # of an older run
        if verdict and verdict.passed:
            return verdict
        if updating:
            new = self._keep(pixels, folder / stem)
            if kept is not None and kept != new:
                kept.unlink()
            self._node.user_properties.append((_UPDATED, str(new)))
            return clrt.compare(pixels, new)
        _make(report.parent)
        if verdict is None:
            found = self._keep(pixels, report.with_suffix(""))
            pytest.fail(f"there is no reference picture {folder / stem}.exr; look at {found}, and keep it "
                        "with --update-pictures")  # fmt: skip
        unsearched = ""
        if scene is not None:
            try:
                causes = clrt.compare(picture, scene, mask=mask).causes
                verdict = replace(verdict, causes=causes or verdict.causes)
            except clrt.ClrtError as error:
                unsearched = f"no cause was looked for in scene=: {error}\n"
        verdict.save_report(report)
        pytest.fail(f"not the picture {kept}: {verdict}\n{unsearched}report: {report}\n"
                    "if it is right as it is now: --update-pictures")  # fmt: skip

    def _stem(self, name: str) -> str:
        """A file's name for a picture of this test, another one for every other picture."""
        whole = self._node.nodeid.partition("::")[2] + (f".{name}" if name else "")
        if whole in self._used:
            pytest.fail(f"{whole}: judged before in this test; give each picture a name of its own")
        self._used.add(whole)
        plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", whole.replace("::", ".")).strip("-.")[:120]
        if plain == whole.replace("::", "."):
            return plain
        return f"{plain}-{hashlib.sha256(whole.encode('utf-8', 'replace')).hexdigest()[:6]}"

    def _report(self, stem: str) -> Path:
        """The report on a picture of this test; tests' files of one name in two folders have one each."""
        given = self._config.getoption("--picture-reports")
        root, test = self._config.rootpath, Path(self._node.path)
        folder = Path(self._config.invocation_params.dir, given) if given else root / REPORTS
        below = test.parent.relative_to(root if test.is_relative_to(root) else test.anchor)
        return folder / below / f"{test.stem}.{stem}.html"

    def _keep(self, pixels: Any, stem: Path) -> Path:
        """Save linear pixels: as .png where these hold all there is, else as .exr."""
        import numpy as np

        import clrt
        from clrt.images.file import decode, encode

        bytes_ = bool(np.array_equal(decode(encode(pixels)), pixels))
        _make(stem.parent)
        return clrt.Image(pixels).save(stem.with_name(stem.name + _KINDS[bytes_]))


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        pytest.fail(f"the folder {folder} cannot be made: {error.strerror or error}")


def pytest_terminal_summary(terminalreporter: Any) -> None:
    reports = [report for found in terminalreporter.stats.values() for report in found]
    updated = {path for report in reports
               for key, path in getattr(report, "user_properties", ()) if key == _UPDATED}  # fmt: skip
    if updated:
        said = f"{len(updated)} reference pictures updated: look at them before you keep them"
        terminalreporter.section(said)
        for path in sorted(updated):
            terminalreporter.line(path)
