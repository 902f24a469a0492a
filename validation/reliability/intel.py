"""The same bits from a compiler that is not LLVM's PoCL: `clrt selftest` on Intel's runtime for processors.

The one that lies beside clrt, else it comes from PyPI, into a folder of its own. It runs on x86-64 processors
of other makers too.
"""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

from clrt.device import intel, vendors
from clrt.device.platforms import VARIABLE

from .figures import Figure, Tell, listed

_PROCESSORS: Final = ("x86_64", "AMD64")


def unable() -> str:
    """Why there is no such runtime for this machine; "" where there is."""
    machine = platform.machine()
    return "" if machine in _PROCESSORS else f"Intel's runtime is for x86-64 processors, not for {machine}"


def run(count: int, tell: Tell) -> Figure:
    """Find or install the runtime, and let it do the self-test, which has `count` checks."""
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="clrt-intel-") as name:
        runtime, found = prepared(Path(name))
        tell(0.1)
        tested = subprocess.run(
            [sys.executable, "-m", "clrt", "selftest", "--device", intel.PLATFORM],
            env={**os.environ, **found},
            capture_output=True,
            text=True,
        )
    checks = checks_of(tested.stdout)
    if tested.returncode not in (0, 1) or not checks:
        raise RuntimeError(
            f"clrt selftest on {runtime}: exit code {tested.returncode}: {tested.stderr[-500:]}"
        )
    wrong = [f"{check}: {detail}" for check, (passed, detail) in checks.items() if not passed]
    return Figure(len(checks), len(wrong), runtime + listed(wrong), time.perf_counter() - start)


def checks_of(text: str) -> dict[str, tuple[bool, str]]:
    """Each check that `clrt selftest` printed: whether it passed, and what it says."""
    lines = re.findall(r"^(same|DIFFERENT) +(.+?) {2,}(.+) \(", text, re.MULTILINE)
    return {check: (verdict == "same", detail) for verdict, check, detail in lines}


def prepared(folder: Path) -> tuple[str, dict[str, str]]:
    """Name and version of the runtime, and what a process needs to see it and no other."""
    if intel.library() is not None:
        version = importlib.metadata.version(intel.PACKAGES[0])
        return f"{intel.PACKAGES[0]} {version}, beside clrt", {VARIABLE: "intel"}
    return install(folder), environment(folder)


def install(folder: Path) -> str:
    """Put the runtime below a folder: its name and version."""
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--ignore-installed", "--prefix", str(folder)]
    subprocess.run([*pip, "--disable-pip-version-check", *intel.PACKAGES], check=True)
    version = next(folder.rglob("intel_opencl_rt-*.dist-info")).name.removesuffix(".dist-info").split("-")[1]
    return f"{intel.PACKAGES[0]} {version}"


def environment(folder: Path) -> dict[str, str]:
    """What a process needs to see the runtime installed below a folder, and no other."""
    library = next(folder.rglob("libintelocl.so"))
    icd = folder / "intel.icd"  # the one that it brings names a place on the machine of its maker
    icd.write_text(f"{library}\n")
    return {vendors.VARIABLE: str(icd), "LD_LIBRARY_PATH": str(library.parent)}
