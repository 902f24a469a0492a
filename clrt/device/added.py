"""What the environment adds to a program, beside its source: options of compilers, another processor.

Whatever is kept of programs or of what they computed is kept by this, too.
"""

from __future__ import annotations

import os
from typing import Final

_VARIABLES: Final = (
    "PYOPENCL_BUILD_OPTIONS",
    "POCL_EXTRA_BUILD_FLAGS",
    "POCL_LLVM_CPU_NAME",
    "CL_CONFIG_CPU_TARGET_ARCH",
)


def added() -> dict[str, str]:
    """The variables that are set, with what they say; an empty one adds nothing."""
    return {name: os.environ[name] for name in _VARIABLES if os.environ.get(name)}
