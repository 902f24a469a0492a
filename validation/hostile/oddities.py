"""What a command line, its files, its environment and its descriptors are made of when they are odd."""

from __future__ import annotations

from typing import Final

OPTIONS: Final = (
    b"--width", b"--height", b"--crop", b"--spp", b"--max-depth", b"--device", b"--threads", b"--limit",
    b"--layers", b"--stats", b"--exposure", b"--bits", b"--checkpoint", b"--check", b"--quiet", b"--json",
    b"--mask", b"--bands", b"--only", b"--case", b"--seed", b"--random", b"--compare", b"--help",
    b"--version", b"--nothing", b"--set", b"--adaptive", b"--view", b"--trace", b"--keyframes", b"--frames",
    b"--manifest", b"--fps", b"--least",
)  # fmt: skip

VALUES: Final = (
    b"", b"-1", b"0", b"1", b"2", b"9", b"1e20", b"1e400", b"9" * 400, b"9" * 100_000, b"nan", b"-inf",
    b"0x10", b"1.5", "²".encode(), "٣".encode(), b" 1 ", b"1,2", b",,,", b"a" * 300, b"a" * 100_000,
    b"\x1b[31mred", b"\xff\xfe", b"new\nline", "\u202eabc".encode(), b"--", b"-", b"%s%n", b"depth,shape",
    b"depth," * 9999, b"generation_1", b"generation_99999999999", b"depth=1e18", b"depth=999999999999999999",
    b"work=-1", b"work=1", b"device_bytes=1", b"file_bytes=0", b"nothing=1", b"pixels=1", b"samples=0", b"=",
    b"4294967296", b"18446744073709551616", b"-2147483649", b"file_bytes=999999999999999999", b"2147483647",
    b"random " + b"9" * 5000 + b"/0", b"{" + b"a." * 9999 + b"b = 1}",
)  # fmt: skip

WRITTEN: Final = {
    b"--stats": b"also.json", b"--trace": b"also.json", b"--manifest": b"also.csv",
    b"--checkpoint": b"also.part",
}  # fmt: skip
"""Options whose value is a file that is written, and a name for it."""

MEANT: Final[dict[bytes, tuple[bytes, ...]]] = {
    b"--set": (
        b"camera.fov=30", b"camera.fov=30,40", b"camera.fov=20:40:2", b"camera.fov=nan", b"camera.fov=",
        b"camera.fov=1:2:99999999999", b"camera.fov=1:1e400:2", b"camera.K=[[9,0,4],[0,9,3],[0,0,1]]",
        b"shapes[0].radius=-1", b"shapes[-1].radius=1", b"shapes[99].radius=1", b"ambient=1e300",
        b"shapes[" + b"9" * 5000 + b"]=1", b"lights=[]", b"max_depth=9999999", b"camera.spp=2", b"=1", b"[[[",
        b"a" + b".a" * 9999 + b"=1", b"materials.x={}", b"background='/dev/zero'", b"camera={}",
        b"camera.fov.x=1", b"shapes=[]",
    ),
    b"--adaptive": (b"4", b"16", b"64", b"3", b"4096"),
    b"--view": (b"ACES 2.0 - SDR 100 nits (Rec.709)", b"Raw", b"raw"),
    b"--keyframes": (b"path.toml", b"scene.toml", b".", b"/dev/zero", b"missing.json"),
    b"--frames": (b"3", b"1048577"),
    b"--fps": (b"25", b"1001"),
}  # fmt: skip
"""Values that an option means, or nearly."""

TEMPLATES: Final = (
    b"out{index}.png", b"out{index}.exr", b"out{index:03}.png", b"out.png", b"out{}.png", b"out{nothing}.png",
    b"{camera.fov}.png", b"out{index.__class__}.png", b"out{index:99999999999}.png", b"out{index",
    b"out{index}", b"out}{.png", b"out{index!r}.png", b"out{index}/x.png", b"out.mp4", b"out.mkv",
    b"out.webm", b"{index}\xff.png",
)  # fmt: skip
"""Names of a series' pictures."""

MANY: Final = (1, 1, 1, 2, 300, 3000)

NAMES: Final = (
    b"\xff\xfe", b"a b", b"\x1b[31mred", b"new\nline", b"tab\t", "\u202eabc".encode(), "ü".encode(), b"-x",
    b"--help", b"a" * 246, b"a" * 300, b"a" * 5000, b"deep/" * 50 + b"x", b"%s%n", b"$HOME", b"~", b"'\"",
    b"#", b"?", b"*",
)  # fmt: skip
"""Of files, without their suffix."""

PLACES: Final = (
    "fifo", "folder", "loop", "dangling", "socket", "-> /dev/zero", "-> /proc/self/mem", "-> .", "-> /",
)  # fmt: skip
"""What stands there instead of a file; "->" is a link."""

_TRAP: Final = b"raise SystemExit(7)\n"

NEIGHBOURS: Final[dict[bytes, tuple[bytes | str, ...]]] = {
    b"matplotlibrc": (b"text.usetex: True\nfont.size: 40\n", b"font.size: \xff", "fifo", "folder", "loop"),
    b"cl.cfg": (b"CL_CONFIG_DEVICES = gpu\n", "fifo"),
    b"librt.so.1": (b"\x7fELF", "folder"),
    **dict.fromkeys((b"json.py", b"ctypes.py", b"multiprocessing.py", b"numpy.py", b"clrt.py"), (_TRAP,)),
    **dict.fromkeys((b"sitecustomize.py", b"validation.py", b"mitsuba.py"), (_TRAP,)),
}
"""What lies in the current folder, and is neither obeyed, nor run, nor waited for."""

SPELLINGS: Final = ((b"", b""), (b"", b"/"), (b"", b"//"), (b"", b"/."), (b"./", b""), (b"./", b"/./"))
"""What may stand before and behind a name without changing which file it means to us."""

STREAMS: Final = ("pipe", "pipe", "pipe", "closed", "full", "broken", "unread", "terminal")
"""What stdout and stderr may be: the last ones fail, are never read, or are a terminal."""

FOLDERS: Final = (
    b"/proc", b"/proc/nothing", b"", b".", b"relative", b"file", b"file/below", b"loop", b"\xff\xfe",
    b"new\nline", b"\x1b[31m", b"a" * 300, (b"c" * 199 + b"/") * 5, b"b/" * 600, b"d/" * 2100,
    b"world", b"spoiled",
)  # fmt: skip
"""What a variable may say instead of a folder; the last ones exist, and hold what others put there."""

_LOCALES: Final = (b"C", b"POSIX", b"C.UTF-8", b"en_US.ISO-8859-1", b"tr_TR", b"xx", b"\xff")
_NUMBERS: Final = (b"0", b"-1", b"1", b"99999", b"x", b"")
_HOMES: Final = (
    b"HOME", b"XDG_CACHE_HOME", b"XDG_CONFIG_HOME", b"TMPDIR", b"POCL_CACHE_DIR", b"MPLCONFIGDIR",
    b"OCL_ICD_VENDORS", b"OPENCL_VENDOR_PATH", b"OCL_ICD_FILENAMES", b"LD_LIBRARY_PATH",
)  # fmt: skip

VARIABLES: Final[dict[bytes, tuple[bytes, ...]]] = {
    **dict.fromkeys((b"LC_ALL", b"LANG"), _LOCALES),
    **dict.fromkeys(_HOMES, FOLDERS),
    **dict.fromkeys((b"COLUMNS", b"LINES", b"OMP_NUM_THREADS", b"OPENIMAGEIO_THREADS"), _NUMBERS),
    **dict.fromkeys((b"POCL_MAX_PTHREAD_COUNT", b"POCL_CPU_MAX_CU_COUNT", b"POCL_MEMORY_LIMIT"), _NUMBERS),
    **dict.fromkeys((b"NO_COLOR", b"FORCE_COLOR", b"CI", b"OIIO_LOG_TIMES", b"PYTHONUTF8"), (b"0", b"1")),
    **dict.fromkeys((b"PYTHONUNBUFFERED", b"PYTHONDONTWRITEBYTECODE", b"PYTHONDEVMODE"), (b"1",)),
    **dict.fromkeys((b"PYOPENCL_NO_CACHE", b"PYOPENCL_COMPILER_OUTPUT"), (b"1",)),
    b"CLRT_DEVICE": (b"", b"nothing", b"0", b"-1", b"9" * 99, b"\xff", b"\x1b[31m", b"PoCL", b"a" * 9999),
    b"CLRT_DRIVER": (b"", b"pocl", b"intel", b"nothing", b"\xff"),
    b"POCL_MAX_WORK_GROUP_SIZE": (b"1", b"0", b"-1", b"7", b"4096", b"x"),
    b"POCL_DEVICES": (b"", b"basic", b"pthread", b"nothing", b"pthread pthread"),
    b"POCL_WORK_GROUP_METHOD": (b"loops", b"workitemrepl", b"cbs", b"x"),
    b"POCL_KERNEL_CACHE": (b"0", b"1", b"x"),
    b"PYOPENCL_CTX": (b"0", b"9", b"x"),
    b"PYTHONIOENCODING": (b"ascii", b"latin-1:strict", b"ascii:strict"),
    b"PYTHONWARNINGS": (b"error", b"always", b"x"),
    b"PYTHONOPTIMIZE": (b"2",),
    b"TERM": (b"", b"dumb", b"xterm-256color", b"x"),
    b"MPLBACKEND": (b"x", b"TkAgg", b"module://nothing"),
    b"MATPLOTLIBRC": (b"file", b"loop", b"neighbour"),
    b"PATH": (b"", b"/proc", b"file"),
    b"TZ": (b"x", b"\xff"),
    b"SOURCE_DATE_EPOCH": (b"x", b"-1", b"9" * 400),
    b"DISPLAY": (b":99",),
    b"OCIO": (b"file", b"/proc", b"pipe", b"/dev/zero", b"ocio://nothing"),
}
"""Environment variables that clrt, Python, the driver or a library of ours reads, and what they may say."""
