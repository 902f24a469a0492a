"""An image as labelled arrays: `xarray.Dataset`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from clrt.base.errors import ClrtError, MissingPackage
from clrt.base.install import pip_install
from clrt.base.layers import RANKS, find

if TYPE_CHECKING:
    from clrt.images.image import Image

_AXES: Final = {"light": ("channel", ["R", "G", "B"]), "luminance": ("cie", ["X", "Y", "Z"]),
                "direction": ("axis", ["x", "y", "z"]), "place": ("axis", ["x", "y", "z"]),
                "coordinates": ("coordinate", ["u", "v"]), "color": ("channel", ["R", "G", "B"]),
                "mattes": ("rank", [f"{part} {rank}" for rank in range(RANKS)
                                    for part in ("id", "share")])}  # fmt: skip


def dataset(image: Image) -> Any:
    """What `Image.to_xarray` promises."""
    try:
        import xarray
    except ImportError:
        need = f"to_xarray: needs xarray; install it with: {pip_install('xarray')}"
        raise MissingPackage(need) from None
    coords: dict[str, Any] = {"y": np.arange(image.height), "x": np.arange(image.width)}
    arrays: dict[str, Any] = {}
    for name, values in {"pixels": image.pixels, **image.layers}.items():
        dims: tuple[str, ...] = ("y", "x")
        if name == "bands":
            dims += ("wavelength",)
            coords["wavelength"] = ("wavelength", list(image.wavelengths), {"units": "nm"})
        elif values.ndim == 3:
            axis, labels = _AXES.get(find(name).picture if name != "pixels" else "light", ("", []))
            if len(labels) == values.shape[2]:
                coords[axis] = labels
            else:  # a layer of the caller's own
                axis = f"{name} part"
            dims += (axis,)
        about = "linear Rec.709 radiance" if name == "pixels" else find(name).holds
        arrays[name] = (dims, values, {"long_name": about})
    taken = [name for name in image.layers if name == "pixels" or name in coords]
    if taken:
        axes = f"a Dataset has pixels and {', '.join(coords)} of its own"
        raise ClrtError(f"layers[{taken[0]!r}]: {axes}; give the layer another name")
    return xarray.Dataset(arrays, coords, dict(image.metadata))
