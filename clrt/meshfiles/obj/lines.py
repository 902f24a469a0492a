"""OBJ files as trimesh understands them: it counts back from the file's end, and sees only plain lines.

A vertex number below 0 counts back from the line where it stands, and that is where most files with such
numbers differ: faces stand among the vertices. Lines that are indented, have tabs or a comment behind them,
or end as on old Macintoshes would be passed over without a word, and so would the first one behind a byte
order mark, and what of a face stands behind a line's end.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from clrt.base.errors import show
from clrt.base.mark import unmarked
from clrt.meshfiles.broken import BrokenMesh, check_narrow

_ODD: Final = re.compile(
    rb"^[ \t]++[a-z]"  # indented
    rb"|^[a-z]++\t"  # a tab behind the keyword
    rb"|^[a-z][^\n#]*+#"  # a comment behind
    rb"|^fo[ \t]"  # a face, as OBJ once spelt it
    rb"|^f[^\n]*?[ \t/][-+0]"  # a number that counts back, or is none
    rb"|\r(?!\n)"
    rb"|\\\r?\n",  # a line that goes on in the next
    re.MULTILINE,
)
_COMMENT: Final = re.compile(rb"#(?!(?<=[0-9]\.#)(?i:ind|inf|qnan|snan))")  # not in 1.#IND, Microsoft's NaN
_FREE: Final = re.compile(rb"[^#]*#|[ \t]*(?:usemtl|mtllib|[og])[ \t]")  # lines that say what they like
_LEAST: Final = {b"v": 3, b"vt": 1, b"vn": 3, b"f": 3}  # words behind them
_COUNTED: Final = (b"v", b"vt", b"vn")
_NAMES: Final = (b"usemtl", b"newmtl", b"mtllib", b"norm", b"o", b"g")  # keywords that a name follows
_UNREAD: Final = {
    b"l": "lines", b"p": "points", b"curv": "curves", b"surf": "free-form surfaces",
}  # fmt: skip
# of the form of the key a line that is no face of it; a search begins with bytes, which takes far less time
_OTHERS: Final = {
    form: re.compile(rb"\nf (?!(?:[ \t]*+" + corner + rb"(?![0-9/]))++[ \t\r]*+(?:\n|\Z))")
    for form, corner in {
        (False, False): rb"[0-9]++", (True, False): rb"[0-9]++/[0-9]++", (False, True): rb"[0-9]++//[0-9]++",
        (True, True): rb"[0-9]++/[0-9]++/[0-9]++",
    }.items()
}  # fmt: skip
_NARROW: Final = re.compile(rb"\nf(?:[ \t]++[^ \t\r\n]++){0,2}+[ \t\r]*+(?:\n|\Z)")


def plain_obj(data: bytes) -> bytes:
    """The file's data with plain lines and faces that count from the file's start, from 1.

    BrokenMesh for a vertex number that is 0, or counts back beyond the start.
    """
    check_narrow(data)
    data = unmarked(data)
    _check_end(data)
    if not _ODD.search(data):
        return data
    lines: list[bytes] = []
    counts = dict.fromkeys(_COUNTED, 0)
    for _, words in _numbered(data):
        if words[0] in counts:
            counts[words[0]] += 1
            words[1:] = [b"nan" if b"#" in word else word for word in words[1:]]
        elif words[0] == b"f":
            words[1:] = [_from_start(corner, counts) for corner in words[1:]]
        elif words[0] in _NAMES:  # to trimesh such a line, too, would go on
            words[-1] = words[-1].rstrip(b"\\")
        lines.append(b" ".join(words))
    return b"\n".join(lines) + b"\n"


def words_of(line: bytes) -> list[bytes]:
    """The words of a line before its comment. In names `#25` is a word, as of 3ds Max, and `# 25` none."""
    words = _COMMENT.split(line, maxsplit=1)[0].split()
    key = words[0].lower() if words else b""
    if key in _NAMES or key.startswith(b"map_"):
        words = line.split()
        return words[: words.index(b"#")] if b"#" in words else words
    return words


def _check_end(data: bytes) -> None:
    """Raise BrokenMesh for a last line without an end that is none: what follows is missing."""
    last = data[max(data.rfind(b"\n"), data.rfind(b"\r")) + 1 :]
    words = _COMMENT.split(last, maxsplit=1)[0].split()
    least = _LEAST.get(words[0]) if words else None
    if least is None:
        return
    forms = {formed(b"f " + word)[0] for word in words[1:]} if words[0] == b"f" else set()
    if len(words) - 1 < least or len(forms) > 1 or words[-1].endswith((b"/", b"\\")):
        number, line = len(data.splitlines()), show(b" ".join(words).decode("latin-1")[:60])
        raise BrokenMesh(f"it ends within line {number}, {line}; it may be cut short")


def check_lines(data: bytes) -> None:
    """Raise BrokenMesh for the first line of a file that cannot be read as one of vertices or of a face.

    It takes far longer than trimesh, whose own words name no line, and so is for files that it refused.
    """
    data = unmarked(data)
    _check_end(data)
    vertices = sum(words[0] == b"v" for _, words in _numbered(data))
    counts = dict.fromkeys(_COUNTED, 0)
    for number, words in _numbered(data):
        try:
            if words[0] in counts:
                counts[words[0]] += 1
                _check_numbers(words)
            elif words[0] == b"f":
                for corner in words[1:]:
                    first = int(_from_start(corner, counts).partition(b"/")[0])
                    if first > vertices:
                        raise BrokenMesh(f"a face names v {first}, and there are {vertices} of them")
        except BrokenMesh as error:
            raise BrokenMesh(f"line {number}: {error}") from None


def _numbered(data: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """The words of each line that has some, and its number: the first of those over which it goes on."""
    parts: list[bytes] = []
    for number, line in enumerate([*data.splitlines(), b""], 1):  # of bytes: at \n, \r and \r\n only
        # a comment, or a name, may be a folder's
        goes_on = line.endswith(b"\\") and not _FREE.match(line)
        parts.append(line[:-1] if goes_on else line)
        if not goes_on:
            words = words_of(b" ".join(parts))
            words[:1] = [b"f"] if words[:1] == [b"fo"] else words[:1]
            if words:
                yield number - len(parts) + 1, words
            parts.clear()


def _check_numbers(words: list[bytes]) -> None:
    """Raise BrokenMesh for a line of vertices, normals or uv with words that are no numbers, or too few."""
    for word in words[1:]:
        try:
            float(word.replace(b"_", b"?"))  # Python's numbers may have these
        except ValueError:
            said = "; decimals have a point" if b"," in word else ""
            raise BrokenMesh(f"{_text(word)} is no number{said}") from None
    if len(words) <= _LEAST[words[0]]:
        raise BrokenMesh(f"{_text(b' '.join(words))} has fewer than {_LEAST[words[0]]} numbers")


def _text(word: bytes) -> str:
    return show(word.decode("latin-1"))


def left_out(data: bytes) -> list[str]:
    """What a file of plain lines states beside faces that have a surface."""
    found = sorted(_UNREAD[word] for word in _UNREAD if _first(data, word) is not None)
    return [*found, *(["faces of fewer than 3 corners"] if _NARROW.search(data) else [])]


def has_colors(data: bytes) -> bool:
    """Whether vertices have colours, `v x y z r g b`, by the first of them."""
    return len((_first(data, b"v") or b"").split()) > 6


def mixed_forms(data: bytes) -> bool:
    """Whether some corners of the faces of plain lines have numbers (of uv, of normals) that others lack."""
    return form_of(data) is None


def form_of(data: bytes) -> tuple[bool, bool] | None:
    """Whether all corners of the faces of plain lines have uv, and normals; None where some have."""
    face = _first(data, b"f")
    form = (False, False) if face is None else formed(face)[0]
    return form if face is None or _OTHERS[form].search(data) is None else None


def _first(data: bytes, word: bytes) -> bytes | None:
    """The first line that a word begins, if any does."""
    head = word + b" "
    start = 0 if data.startswith(head) else data.find(b"\n" + head) + 1
    end = data.find(b"\n", start)
    return data[start : end if end >= 0 else None] if start or data.startswith(head) else None


def formed(face: bytes) -> tuple[tuple[bool, bool], bytes]:
    """Whether all corners of a face have uv, and normals, and the line with no more than all have."""
    corners = [[*corner.split(b"/"), b"", b""][:3] for corner in face.split()[1:]]
    uv, normals = (all(corner[kind] for corner in corners) for kind in (1, 2))
    words = [
        v + (b"/" + vt if uv else b"/" if normals else b"") + (b"/" + vn if normals else b"")
        for v, vt, vn in corners
    ]
    return (uv, normals), b" ".join([b"f", *words])


def _from_start(corner: bytes, counts: dict[bytes, int]) -> bytes:
    """A corner such as `-1//-1` with numbers that count from the start."""
    numbers = corner.split(b"/")
    if not numbers[0]:
        raise BrokenMesh(f"a face names {_text(corner)}, which has no number of a vertex")
    for place, kind in zip(range(len(numbers)), _COUNTED, strict=False):
        if not numbers[place]:
            continue
        try:
            number = int(numbers[place].replace(b"_", b"?"))  # Python's numbers may have these
        except ValueError:
            raise BrokenMesh(f"a face names {_text(numbers[place])}, which is no whole number") from None
        found = number if number >= 0 else counts[kind] + number + 1
        if found < 1:
            what = f"{kind.decode()} {number}"
            raise BrokenMesh(f"a face names {what} after {counts[kind]} of them; the first is 1, the last -1")
        numbers[place] = b"%d" % found
    return b"/".join(numbers)
