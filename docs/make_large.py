"""What one, three and ten million triangles take, for docs/live-scenes.md: `python docs/make_large.py`.

Each is written as a PLY file and loaded from it, by a process of its own, with one thread. Raw values go to
docs/performance/large.json; the table between the marks of the page follows from them (`table`). About ten
minutes, and eight gigabytes of memory.

    python docs/make_large.py 10000 30000    these sizes; nothing is kept, the table is printed
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))

from validation.reliability import kept  # noqa: E402

SIZES = (10**6, 3 * 10**6, 10**7)
PAGE, KEPT = FOLDER / "live-scenes.md", "performance/large.json"
BEGIN, END = "<!-- large -->", "<!-- end large -->"

WRITE = """\
import sys
import numpy as np
import clrt
from clrt.bench import scenes
scene = scenes.terrain(int(sys.argv[1]))
mesh = scene.shapes[0]
vertices, faces = np.asarray(mesh.data().vertices, "<f4"), np.asarray(mesh.faces)
row = np.empty(len(faces), [("n", "u1"), ("corners", "<i4", 3)])
row["n"], row["corners"] = 3, faces
with open("large.ply", "wb") as file:
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    file.write("\\n".join(head).encode())
    file.write(vertices.tobytes())
    file.write(row.tobytes())
shape = {"type": "mesh", "file": "large.ply", "material": scene.shapes[0].material}
scene.replace({"shapes": [shape]}).save("large.toml")
"""

TAKE = """\
import json, time
import clrt
from clrt.bench import machine
start = time.process_time()
scene = clrt.load("large.toml")
loaded = time.process_time()
with clrt.Tracer(scene, settings=clrt.Settings(threads=1)) as tracer:
    ready = time.process_time()
    image = tracer.render(width=256, height=256)
    told = {"triangles": len(tracer.flat.triangles), "hits": image.stats["rays"]["camera_hits"]}
    told |= {"load": loaded - start, "tracer": ready - loaded, "peak_bytes": machine.peak_bytes()}
    print(json.dumps(told))
"""


def taken(size: int, folder: str) -> dict[str, Any]:
    """Processor seconds to load a terrain of about so many triangles and for a Tracer of it, and the peak of
    memory, with a picture of 256 x 256."""
    for program in (WRITE, TAKE):
        command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(FOLDER.parent)!r})\n{program}"]
        done = subprocess.run([*command, str(size)], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def in_proportion(few: dict[str, Any], many: dict[str, Any]) -> bool:
    """Whether loading and the Tracer take no more than in proportion to the triangles."""
    return all(many[part] * few["triangles"] <= few[part] * many["triangles"] for part in ("load", "tracer"))


def table(rows: list[dict[str, Any]]) -> str:
    """Of the page."""
    lines = ["| triangles | loaded | new `Tracer` | of the first | memory at most, with a picture |"]
    lines.append("| ---: | ---: | ---: | ---: | ---: |")
    for row in rows:
        share = row["tracer"] / rows[0]["tracer"]
        cells = f"{row['triangles']:,} | {row['load']:.1f} s | {row['tracer']:.1f} s | {share:.1f} times"
        lines.append(f"| {cells} | {row['peak_bytes'] / 2**30:.1f} GiB |")
    return "\n".join(lines)


def main() -> None:
    """Measure, and write file and page."""
    sizes, stamp = [int(word) for word in sys.argv[1:]], kept.stamp(kept.FILES[KEPT])
    rows = []
    for size in sizes or SIZES:
        with tempfile.TemporaryDirectory() as folder:
            rows.append(taken(size, folder))
            print(rows[-1], flush=True)
    if sizes:
        return print(table(rows))
    (FOLDER / KEPT).write_text(json.dumps({"stamp": stamp, "rows": rows}, indent=1) + "\n", encoding="utf-8")
    before, rest = PAGE.read_text("utf-8").split(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}\n{table(rows)}\n{END}{rest.split(END)[1]}", encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
