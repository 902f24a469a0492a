"""The manifest of a series: which picture each file holds, and by which values; a later run goes on by it."""

from __future__ import annotations

import csv
import hashlib
import io
import math
import os
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Final, TextIO

from clrt.base import inputs
from clrt.base.atomic import check_replaceable, replacing
from clrt.base.errors import ClrtError, legible
from clrt.base.files import opened
from clrt.base.limits import Limits

Row = dict[str, Any]
_OWN: Final = ("index", "file", "picture", "sha256", "identity", "rays")
_FIRST: Final = ",".join(_OWN[:2])  # what every manifest begins with
_FORMULA: Final = ("=", "+", "-", "@", "\t", "\r")  # with these a spreadsheet begins to compute
_COLUMNS: Final = 256  # a table that is written has all of them in each row
_SHARE: Final = 0.05  # of the time that saving may take


class Manifest:
    """The manifest of a series to files of these names; None as a path: there is none.

    series: for each picture, its values by their places. What the file that is there says of pictures of
    other names stays in it, as long as there are files of these names. ClrtError where that file is no
    manifest, or cannot be replaced.
    """

    def __init__(
        self, path: str | None, names: Iterable[str], series: Sequence[dict[str, Any]], limits: Limits
    ) -> None:
        self.path, self.series = path, series
        self._most = limits.image_bytes
        self.rows: dict[int, Row] = {}
        self.kept = 0  # pictures that were there
        self._before: dict[tuple[str, str], Row] = {}
        self._others: dict[str, Row] = {}
        self._took, self._last = 0.0, time.monotonic()
        if path is not None:
            check_replaceable(path)
            files = [Path(name) for name in names]
            own = {cell(name) for file in files for name in (self._name(file), file.name)}
            parent = os.path.dirname(path)
            listed = self._listed({Path(path).parent, *(file.parent for file in files)})

            @cache
            def there(name: str) -> bool:
                return name in listed or os.path.exists(os.path.join(parent, name))

            for row in _read(path, limits):
                name = row["file"]
                if name in own:
                    self._before[name, row["identity"]] = row
                elif there(name):
                    self._others[name] = row

    def keeps(self, index: int, file: Path, identity: str) -> bool:
        """Note a picture that is wanted; whether its file holds it, as the manifest of before says.

        A file beyond the limit of pictures is not looked through: its picture is made anew.
        """
        names = self._name(file), file.name  # older versions left the folder out
        row = self.rows[index] = {"index": index, "file": names[0], "identity": identity}
        found = (self._before.get((cell(name), identity)) for name in names)
        old = next(filter(None, found), None)
        if old is None or old["sha256"] != _sha256(file, self._most):
            return False
        row |= {"picture": old["picture"], "sha256": old["sha256"], "rays": old["rays"]}
        self.kept += 1
        return True

    def note(self, index: int, picture: str, file: Path | None, rays: int) -> None:
        """A picture is finished, and saved to a file (or is part of a film); save now and then."""
        sha256 = "" if file is None else _sha256(file)
        self.rows[index] |= {"picture": picture, "sha256": sha256, "rays": rays}
        if file is not None and (time.monotonic() - self._last) * _SHARE >= self._took:
            self.save()

    def _name(self, file: Path) -> str:
        """A file as the manifest names it: as seen from its own folder."""
        if self.path is None:
            return file.name
        try:
            return Path(os.path.relpath(file, Path(self.path).parent)).as_posix()
        except ValueError:  # of another drive
            return file.name

    def _listed(self, folders: set[Path]) -> set[str]:
        """The names of all that is in these folders, as cells have them."""
        found: set[str] = set()
        for folder in folders:
            with suppress(OSError):  # whoever writes there says what is wrong
                found |= {cell(self._name(folder / name)) for name in os.listdir(folder)}
        return found

    def finished(self) -> list[Row]:
        """What is known of the pictures that there are, by their numbers."""
        return [self.rows[index] for index in sorted(self.rows) if "picture" in self.rows[index]]

    def save(self) -> None:
        """Replace the file, if any picture is finished; what is not looked at yet stays as it was known."""
        rows = self.finished()
        if self.path is None or not rows:
            return
        start = time.monotonic()
        done = {cell(name) for row in rows for name in (row["file"], Path(row["file"]).name)}
        kept = [row for row in self._before.values() if row["file"] not in done]
        kept += self._others.values()
        places = dict.fromkeys(cell(place) for values in self.series for place in values)
        places |= dict.fromkeys(place for row in kept for place in row if place not in _OWN)
        out = io.StringIO(newline="")
        table = csv.writer(out)
        table.writerow([*_OWN[:2], *places, *_OWN[2:]])
        for row in rows:
            values = {cell(place): cell(value) for place, value in self.series[row["index"]].items()}
            cells = [values.get(place, "") for place in places]
            table.writerow([row["index"], cell(row["file"]), *cells, *(row[name] for name in _OWN[2:])])
        for row in kept:
            cells = [row.get(place, "") for place in places]
            table.writerow([row["index"], row["file"], *cells, *(row[name] for name in _OWN[2:])])
        with replacing(self.path) as temporary:
            temporary.write_text(out.getvalue(), encoding="utf-8", newline="")
        self._last = time.monotonic()
        self._took = self._last - start


def cell(value: Any) -> Any:
    """A value as a spreadsheet may show it: texts that it would compute begin with an apostrophe."""
    if isinstance(value, (int, float)):
        return value
    text = str(legible(str(value)))
    return f"'{text}" if text.startswith(_FORMULA) else text


def _read(path: str, limits: Limits) -> list[Row]:
    """The rows of pictures with files, of a manifest that is there; none of a damaged one.

    ClrtError for a file that never was one: somebody else's, which nothing may replace.
    """
    if not Path(path).exists():
        return []
    with inputs.watched(False), opened(path, limits) as binary:
        file = io.TextIOWrapper(binary, encoding="utf-8-sig", errors="surrogateescape", newline="")
        first = file.read(len(_FIRST))
        if first and first != _FIRST:
            text = "is there, and is no manifest of clrt; give --manifest the name of another file"
            raise ClrtError(f"{path}: {text}")
        file.seek(0)
        return _rows(file)


def _rows(file: TextIO) -> list[Row]:
    """Short rows cost as much as they hold, however many columns the first line names."""
    try:
        table = csv.reader(map(legible, file))
        names = next(table, [])
        needed = set(_OWN)
        if len(names) > _COLUMNS or not needed <= set(names):
            return []
        rows = (dict(zip(names, texts, strict=False)) for texts in table)
        return [
            {name: text for name, text in row.items() if name in _OWN or (name and text)}
            for row in rows
            if row.get("file") and row.get("sha256") and row.keys() >= needed
        ]
    except (ValueError, csv.Error):
        return []


def _sha256(path: Path, most: float = math.inf) -> str:
    """Of a file; "" of what cannot be read, or has more bytes than `most`."""
    try:
        if path.stat().st_size > most:
            return ""
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
