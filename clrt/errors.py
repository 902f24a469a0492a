"""The errors and warnings a user can meet; each one line: where, what, and what would be right."""

from __future__ import annotations


class ClrtError(Exception):
    """A fault of the user's making; the command line prints it in one line and exits with 2."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class SceneError(ClrtError):
    """A scene, or a file that belongs to it, says something that cannot be rendered."""


class DeviceError(ClrtError):
    """No OpenCL device fits, or its driver refused."""


class LimitError(ClrtError):
    """A scene or a render would cost more than `clrt.limits.Limits` allows."""


class MemoryLimitError(LimitError):
    """There is no room on the device for one buffer more; with smaller tiles there may be."""


class ClrtWarning(UserWarning):
    """Something that is allowed but probably not meant."""


NO_MEMORY = "this machine has no memory left for it; use a smaller scene or picture, or fewer layers"


def one_line(text: str) -> str:
    """`text` with every run of white space, line breaks included, as one space."""
    return " ".join(text.split())


def show(value: object, width: int = 60) -> str:
    """`value` as a message shows it: its repr in one line of at most `width` characters."""
    try:
        text = one_line(repr(value))
    except (ValueError, RecursionError):  # an int of too many digits, an endless structure
        text = f"a {type(value).__name__}"
    return text if len(text) <= width else text[: width - 3] + "..."


def located(source: str, place: str, text: str) -> str:
    """'file: place: text', without the parts that are empty."""
    return ": ".join(part for part in (source, place, text) if part)


def fault(source: str, place: str, value: object, right: str) -> str:
    """The usual message: `room.toml: shapes[3].radius: -1.0 is not allowed; a radius must be > 0`."""
    return located(source, place, f"{show(value)} is not allowed; {right}")
