"""The roofline chart (Williams, Waterman, Patterson 2009): how near each pass is to the device's best."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any, Final

import numpy as np

from clrt.base.errors import ClrtError
from clrt.bench.report import Report
from clrt.bench.timing import Measurement
from clrt.images.plotting import drawing, known_formats, save, subplots

_NO_ROOF: Final = "a roofline chart needs the kernels' measurements; leave out --only, or add kernels to it"
_MARKS: Final = {"tracing": "o", "shading": "s", "compaction": "^"}


def check_chart(path: str | Path, groups: Collection[str]) -> None:
    """Raise, before anything is measured, the ClrtError that `roofline` or `save` would."""
    if "kernels" not in groups:
        raise ClrtError(_NO_ROOF)
    known = known_formats()
    suffix = Path(path).suffix.lower().lstrip(".") or "png"
    if suffix not in known:
        raise ClrtError(f"{path}: no chart is drawn as .{suffix}; use one of {', '.join(sorted(known))}")


@drawing()
def roofline(report: Report, path: str | Path) -> Path:
    """Draw every pass with known traffic and operations. ClrtError for a report without the roof."""
    best = report.roof
    drawn = [m for m in report.of(*_MARKS) if m.flops and m.nbytes]
    if best is None or not drawn:
        raise ClrtError(_NO_ROOF)
    figure, axes = subplots(figsize=(9, 6))
    intensity = np.geomspace(0.02, 200, 200)
    for bandwidth, text, style in ((best.memory, "memory", "-"), (best.cache, "a core's cache", ":")):
        height = np.minimum(intensity * bandwidth, best.arithmetic) / 1e9
        axes.plot(
            intensity, height, f"k{style}", lw=1, label=f"copy through {text}: {bandwidth / 1e9:.0f} GB/s"
        )
    names = sorted({m.scene for m in drawn})
    for m in drawn:
        _dot(axes, m, names.index(m.scene))
    for k, name in enumerate(names):
        axes.plot([], [], "o", color=f"C{k}", label=name)
    axes.set(
        xscale="log",
        yscale="log",
        ylim=(0.1, 2 * best.arithmetic / 1e9),
        xlabel="operations a byte of compulsory traffic",
        ylabel=f"Gflop/s on one core (fused multiply-adds: {best.arithmetic / 1e9:.0f})",
        title=f"{report.machine['processor']}, {report.machine['device'].split(' / ')[0]}",
    )
    axes.legend(loc="lower right", frameon=False, fontsize=8)
    return save(figure, path)


def _dot(axes: Any, m: Measurement, scene: int) -> None:
    x, y = m.flops / m.nbytes, m.flops / m.median / 1e9
    axes.plot(x, y, _MARKS[m.group], color=f"C{scene}", ms=5)
    if m.group != "tracing" and scene:
        return  # the other passes hardly depend on the scene: one name each will do
    name, color = (m.queue, f"C{scene}") if m.group == "tracing" else (m.name, "black")
    place = (5, 3 - 5 * scene)
    axes.annotate(name, (x, y), xytext=place, textcoords="offset points", fontsize=6, color=color)
