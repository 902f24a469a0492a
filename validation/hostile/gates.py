"""What an input may cost, and which answers are failures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from clrt.meshfiles.parts import MOST_GROUPS

from .pace import pace

GOOD: Final = ("rendered", "refused", "ended well")

# Until an input is refused or read, above what the process held before; all seconds are those of `pace` 1
MEMORY: Final = 100 << 20  # bytes
MEMORY_PER_BYTE: Final = 60  # for each byte of the input's files
SECONDS: Final = 1.0  # of processor time
SECONDS_PER_BYTE: Final = 1e-6

# Decoded pictures are a limit of their own: for each pixel that a picture declares and the limit allows
MEMORY_PER_PIXEL: Final = 40
SECONDS_PER_PIXEL: Final = 2e-7

# Triangles, which a file may place many times: for each that the scene has, as `Limits.primitives` allows
MEMORY_PER_TRIANGLE: Final = 140
SECONDS_PER_TRIANGLE: Final = 8e-7
RENDER_MEMORY_PER_TRIANGLE: Final = 700
RENDER_SECONDS_PER_TRIANGLE: Final = 4e-6

# Meshes, each with arrays of its own, which a file may place as often: for each of at most so many as one
# model is taken apart to. Half of the 0.55 ms that were measured on a Zen 3, as `SECONDS` has room for more
SECONDS_PER_MESH: Final = 3e-4

# To render what was read, in a picture of at most 4096 pixels and 2,000,000 rays; the scene's tree included
RENDER_MEMORY: Final = 512 << 20
RENDER_SECONDS: Final = 4.0

# A command: the interpreter and what it imports included
COMMAND_MEMORY: Final = 768 << 20
COMMAND_SECONDS: Final = 30.0  # kernels may have to be built


def judged(answer: dict[str, Any]) -> str:
    """The answer's status, or what it cost too much of: "slow", "large"."""
    status: str = answer["status"]
    if status not in GOOD or "read" not in answer:
        return status
    read, render = answer["read"], answer["render"]
    size, pixels, triangles = answer["size"], answer["pixels"], answer.get("triangles", 0)
    seconds = size * SECONDS_PER_BYTE + pixels * SECONDS_PER_PIXEL + triangles * SECONDS_PER_TRIANGLE
    seconds += min(answer.get("meshes", 0), MOST_GROUPS) * SECONDS_PER_MESH
    room = size * MEMORY_PER_BYTE + pixels * MEMORY_PER_PIXEL + triangles * MEMORY_PER_TRIANGLE
    render_seconds = seconds + triangles * RENDER_SECONDS_PER_TRIANGLE
    render_room = room + triangles * RENDER_MEMORY_PER_TRIANGLE
    # what the worker's own limit of rays ends was read whole, and refused for no fault of the input; what
    # rays meet (too many media in one another) is known when they are traced, what a tree takes of the
    # device's memory when it is built, but for what no tree can do without
    late = answer.get("traced") or any(limit in answer["text"] for limit in ("work: ", "device_bytes: "))
    if status == "rendered" or late:
        times = read["seconds"] / (SECONDS + seconds), render["seconds"] / (RENDER_SECONDS + render_seconds)
        large = read["bytes"] > MEMORY + room or render["bytes"] > RENDER_MEMORY + render_room
    else:
        times = (read["seconds"] + render["seconds"]) / (SECONDS + seconds), 0.0
        large = max(read["bytes"], render["bytes"]) > MEMORY + room
    return "slow" if is_slow(max(times)) else "large" if large else status


def is_slow(times: float) -> bool:
    """Whether what took so many times its bound took too long for this core."""
    return times > 1.0 and times > pace()


@dataclass
class Worst:
    """The largest costs of all tasks."""

    read_seconds: float = 0.0
    read_bytes: int = 0
    render_seconds: float = 0.0
    render_bytes: int = 0
    command_seconds: float = 0.0

    def note(self, answer: dict[str, Any]) -> None:
        if "read" in answer:
            read, render = answer["read"], answer["render"]
            self.read_seconds = max(self.read_seconds, read["seconds"])
            self.read_bytes = max(self.read_bytes, read["bytes"])
            self.render_seconds = max(self.render_seconds, render["seconds"])
            self.render_bytes = max(self.render_bytes, render["bytes"])
        self.command_seconds = max(self.command_seconds, answer.get("command seconds", 0.0))

    def told(self) -> str:
        """In words."""
        return (
            f"reading at most {self.read_seconds:.2f} s of processor time and {self.read_bytes >> 20} MiB, "
            f"rendering {self.render_seconds:.2f} s and {self.render_bytes >> 20} MiB, "
            f"a command {self.command_seconds:.1f} s"
        )
