"""A flattened scene as it travels: a recipe of a few bytes, and large arrays known by their digest.

Who has an array already need not be sent it: frames that share a mesh send it to a worker once.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from clrt.base.errors import ClrtError
from clrt.flatten.flatten import FlatScene

LARGE: Final = 1 << 14  # bytes from which something travels only where it lacks: below, asking costs more


@dataclass(frozen=True, eq=False)
class Parcel:
    """A scene, taken apart. scene: its hash. arrays: the large ones by the digest of what they hold."""

    scene: str
    recipe: bytes
    arrays: Mapping[str, np.ndarray]


def packed(flat: FlatScene) -> Parcel:
    """A scene for the way to a worker."""
    scene = flat.hash  # and with it the digests of all sections
    arrays: dict[str, np.ndarray] = {}

    class Taking(pickle.Pickler):
        def persistent_id(self, found: Any) -> str | None:
            if not isinstance(found, np.ndarray) or found.nbytes < LARGE:
                return None
            name = digest(found, flat.digests.get(id(found)))
            arrays[name] = found
            return name

    out = io.BytesIO()
    Taking(out, pickle.HIGHEST_PROTOCOL).dump(flat)
    return Parcel(scene, out.getvalue(), arrays)


def unpacked(scene: str, recipe: bytes, arrays: Mapping[str, np.ndarray]) -> FlatScene:
    """The scene of a recipe, put together from arrays that `digest` knows by these names.

    ClrtError where it is not the one that was packed.
    """

    class Putting(pickle.Unpickler):
        def persistent_load(self, name: Any) -> np.ndarray:
            return arrays[name]

    flat: FlatScene = Putting(io.BytesIO(recipe)).load()
    flat.digests.update({id(array): bytes.fromhex(name.split()[0]) for name, array in arrays.items()})
    if flat.hash != scene:
        raise ClrtError(f"its scene is another one than was sent: {flat.hash[:12]}, not {scene[:12]}")
    return flat


def digest(array: np.ndarray, known: bytes | None = None) -> str:
    """A name for an array: the SHA-256 (hexadecimal) of its bytes, its kind and its shape."""
    if known is None:
        known = hashlib.sha256(np.ascontiguousarray(array).view(np.uint8).data).digest()
    return f"{known.hex()} {array.dtype.descr} {array.shape}"
