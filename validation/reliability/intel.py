"""The same bits from a compiler that is not LLVM's PoCL: `clrt selftest` on Intel's runtime for processors.

It comes from PyPI, into a folder of its own, and runs on processors of other makers too.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

from clrt import vendors

from .figures import Figure, Tell, listed

PACKAGES: Final = ("intel-opencl-rt", "intel-cmplr-lib-rt")
_DEVICE: Final = "Intel(R) OpenCL"


def run(count: int, tell: Tell) -> Figure:
    """Install the runtime, and let it do the self-test, which has `count` checks."""
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="clrt-intel-") as name:
        folder = Path(name)
        runtime = install(folder)
        tell(0.1)
        tested = subprocess.run(
            [sys.executable, "-m", "clrt", "selftest", "--device", _DEVICE],
            env={**os.environ, **environment(folder)},
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


def install(folder: Path) -> str:
    """Put the runtime below a folder: its name and version."""
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--ignore-installed", "--prefix", str(folder)]
    subprocess.run([*pip, "--disable-pip-version-check", *PACKAGES], check=True)
    version = next(folder.rglob("intel_opencl_rt-*.dist-info")).name.removesuffix(".dist-info").split("-")[1]
    return f"{PACKAGES[0]} {version}"


def environment(folder: Path) -> dict[str, str]:
    """What a process needs to see the runtime installed below a folder, and no other."""
    library = next(folder.rglob("libintelocl.so"))
    icd = folder / "intel.icd"  # the one that it brings names a place on the machine of its maker
    icd.write_text(f"{library}\n")
    return {vendors.VARIABLE: str(icd), "LD_LIBRARY_PATH": str(library.parent)}
