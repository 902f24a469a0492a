"""Instructions that OpenCL does not name are used only where the compiler says that it knows each of them."""

from __future__ import annotations

import re
from pathlib import Path

from clrt.base.resources import kernel_folder


def test_each_instruction_is_asked_for() -> None:
    for path in Path(kernel_folder()).glob("*.cl*"):
        text = path.read_text("utf-8")
        asked = set(re.findall(r"__has_builtin\((__builtin_ia32_\w+)\)", text))
        used = set(re.findall(r"(__builtin_ia32_\w+)\(", text))
        assert used == asked, path.name
