"""How OpenCL drivers are found on Linux: the loader, and the files that name the drivers' libraries.

A loader (`libOpenCL.so`) reads `*.icd` files, one library a file, in the folder that OCL_ICD_VENDORS names,
else in /etc/OpenCL/vendors. The loader in pyopencl's wheels looks beside itself, too, where `pip install
pocl-binary-distribution` puts a driver; but where OCL_ICD_VENDORS is no folder, it takes that one file only.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from clrt.base import child
from clrt.base.install import pip_install
from clrt.base.resources import PACKAGE
from clrt.device import cachefolder

VARIABLE: Final = "OCL_ICD_VENDORS"
PLACES: Final = (VARIABLE, "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES", "LD_LIBRARY_PATH", cachefolder.VARIABLE)
"""Variables that name where drivers are, or what they read."""

USUAL_FOLDER: Final = Path("/etc/OpenCL/vendors")


@dataclass(frozen=True)
class Vendor:
    """An `.icd` file, the library that it names, and why that cannot be loaded ('' where it can)."""

    file: Path
    library: str
    fault: str


def install_command(fault: str = "") -> str:
    """What to type for a driver that works on this machine, given what is wrong with the one there is.

    PyPI's PoCL is of 2022 and knows no newer processor; Intel's runtime takes those of any maker, of x86-64.
    """
    if platform.machine().lower() in ("x86_64", "amd64") and sys.platform in ("linux", "win32"):
        if sys.platform == "linux" and not fault:
            return pip_install("pocl-binary-distribution")
        return pip_install("intel-opencl-rt", "intel-cmplr-lib-rt")
    if sys.platform == "darwin":
        return "brew install pocl"
    return "apt-get install pocl-opencl-icd   (Debian, Ubuntu; elsewhere your system's, or the GPU's)"


def vendor_folders() -> list[Path]:
    """Where drivers are looked for, in that order: folders, or a file that OCL_ICD_VENDORS names."""
    wanted = Path(os.environ.get(VARIABLE) or USUAL_FOLDER)
    if os.environ.get(VARIABLE) and not os.path.isdir(wanted):  # False for what can be no name, too
        return [wanted]
    bundled = bundled_folder()
    return [bundled, wanted] if bundled else [wanted]


def announced() -> str:
    """All that decides which drivers a loader starts here: another text means that others may be."""
    told = [f"{name}={os.environ.get(name)}" for name in PLACES if name != cachefolder.VARIABLE]
    told += [f"{file} {file.stat().st_mtime_ns if file.exists() else 0}" for file in files()]
    return "\0".join(told)


def files() -> list[Path]:
    """The `.icd` files that a loader reads here, in that order."""
    return [file for folder in vendor_folders() if os.path.exists(folder)  # False for what is no name
            for file in ([folder] if os.path.isfile(folder) else sorted(folder.glob("*.icd")))]  # fmt: skip


def bundled_folder() -> Path | None:
    """The folder of libraries inside pyopencl's wheel, where it has one."""
    spec = importlib.util.find_spec("pyopencl")
    for place in spec.submodule_search_locations or [] if spec else []:
        if (Path(place) / ".libs").is_dir():
            return Path(place) / ".libs"
    return None


def vendors(tried: bool = True) -> list[Vendor]:
    """Every driver that is announced here. tried: load each library, in another process, for its fault."""
    found = []
    for file in files():
        try:
            text = file.read_text(encoding="utf-8", errors="replace")
        except OSError as error:
            found.append(Vendor(file, "", f"cannot be read: {error.strerror}"))
            continue
        library = "".join(text.splitlines()[:1]).strip()[:200]
        near = (file.parent / library).absolute()  # pyopencl's own names a library beside it
        path = str(near) if os.path.isfile(near) else library
        found.append(Vendor(file, path, load_fault(path) if tried else ""))
    return found


def loaders() -> list[str]:
    """Libraries called libOpenCL that this process has loaded."""
    try:
        maps = Path("/proc/self/maps").read_text("utf-8", "replace")
    except OSError:
        return []
    return sorted({line.split(maxsplit=5)[-1] for line in maps.splitlines() if "libOpenCL" in line})


def why_none() -> str:
    """Why no driver is found here, as far as the files tell: a clause for an error message."""
    folders = vendor_folders()
    places = ", ".join(map(str, folders))
    if os.environ.get(VARIABLE) and not os.path.exists(folders[-1]):
        return f"{VARIABLE} names {folders[-1]}, which is not there; unset it"
    found = vendors()
    if not found:
        return f"no driver is announced in {places}"
    broken = [vendor for vendor in found if vendor.fault]
    if broken:
        return "; ".join(f"{vendor.file} names {vendor.library}: {vendor.fault}" for vendor in broken)
    return f"{', '.join(vendor.library for vendor in found)} has no platform"


def load_fault(library: str) -> str:
    """Why a library cannot be loaded; tried in another process, since a driver may do anything."""
    code, python = "import ctypes, sys; ctypes.CDLL(sys.argv[1])", child.interpreter()
    if python is None:  # nothing is known against it
        return ""
    try:
        done = subprocess.run(
            [python, "-P", "-c", code, library],
            capture_output=True, text=True, timeout=30, check=False, cwd=PACKAGE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "it does not load within 30 s"
    except (OSError, ValueError) as error:  # no process can be started here, or not with that argument
        return f"it cannot be tried: {getattr(error, 'strerror', None) or error}"
    if done.returncode == 0:
        return ""
    lines = done.stderr.strip().splitlines()
    return lines[-1].removeprefix("OSError: ") if lines else f"loading it ends with code {done.returncode}"
