"""Any two pictures, or a picture and the scene it should show: figures, a verdict and the likely cause.

What `clrt compare` prints. Where one picture comes from a file of integers, both are taken as such files hold
them, so that rounding and clipping alone are no difference; a note says what was clipped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from clrt.images.file import decode, encode
from clrt.judging.verdict import HALF, LOSSY, SHARED_EXPONENT
from clrt.scene.scene import Scene

from ..types import Gate
from .causes import (
    BYTE,
    EXACT,
    FLOAT,
    NOTHING,
    Budget,
    Cause,
    disagreement,
    off_screen,
    ranked,
    tolerance_of,
)
from .curves import clipped, compressed, faded, recurved
from .figures import measured
from .lossy import said, told_apart
from .metrics import (
    Array,
    blocks,
    brightening,
    encoded,
    extended,
    held,
    largest,
    parts,
    share,
    steep,
    without_flip,
)
from .moves import moved, resized
from .oracle import gate, size
from .reference import SceneReference
from .scene import explain_by_scene
from .undo import undoable
from .wanted import asked, check_wanted

SEARCH_SECONDS = 30.0  # of processor time, then the search for causes ends
SIMILAR = 0.95  # SSIM from which pictures count as similar
_NOT_FINITE = "not finite"
_FINAL = ("JPEG compression", "clipped")  # no scene is searched for what they explain
_LOOKED_AT = 1448  # pixels a side, in the middle of larger pictures, that tell of causes in all of it
_PRESSED = 8  # times what a lossy file usually loses, below which nothing is taken for an object
_LARGEST_PLACES = 0.75  # of the picture, as a light may reach; what differs in more of it is no region
_Lossy = tuple[int, Array]  # one of LOSSY, and the picture that was not in such a file


@dataclass(frozen=True)
class PictureComparison:
    """What is to say about a picture and its reference."""

    verdict: str  # "identical", "equal", "same picture", "similar", "different"
    metrics: dict[str, float]
    gates: tuple[Gate, ...]  # of the verdict "same picture"
    causes: tuple[Cause, ...]  # the best first; () where the pictures agree, or nothing helps
    notes: tuple[str, ...] = ()
    asked: bool = False  # whether the gates are the caller's own

    @property
    def passed(self) -> bool:
        """Whether they show the same, as far as an eye and the gates can tell; else whether all gates do."""
        if self.asked:
            return all(gate.passed for gate in self.gates)
        return self.verdict in ("identical", "equal", "same picture")


def compare_pictures(
    picture: Array,
    reference: Array,
    masked: bool = False,
    scene: SceneReference | None = None,
    report: Callable[[str], None] | None = None,
    seconds: float = SEARCH_SECONDS,
    wanted: Mapping[str, float] | None = None,
    bits: tuple[int, int] = (32, 32),
) -> PictureComparison:
    """Compare two linear pictures (h, w, 3) of any sizes.

    masked: leave edges out of differences and causes. scene: what made `reference`, to look for causes in it.
    report: gets the name of each cause before it is tried. seconds: of processor time, after which no further
    cause is looked for in the scene. wanted: limits of figures by name, in place of the usual gates; then
    these alone decide whether the pictures pass. bits: of a sample of both where they were stored; 8 and 16
    are sRGB and end at white, 32 is radiance, and so are HALF, SHARED_EXPONENT and those of LOSSY. ClrtError
    for a name of `wanted` that is no figure's.
    """
    check_wanted(wanted)
    notes = tuple(
        f"{count} pixels of {name} are NaN or infinite; they count as 0"
        for name, image in (("the picture", picture), ("the reference", reference))
        if (count := int(np.count_nonzero(~np.isfinite(image).all(axis=-1))))
    )
    a, b = picture, reference
    if notes:
        a, b = (np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0) for image in (a, b))
    shared = SHARED_EXPONENT in bits
    lossy: list[_Lossy] = [(kind, (b, a)[k]) for k, kind in enumerate(bits) if kind in LOSSY]
    if shared or HALF in bits:
        a = held(a, b, shared) if a.shape == b.shape else a
    bits = _of_floats(bits[0]), _of_floats(bits[1])
    finite: tuple[Gate, ...] = ()
    if notes:
        finite = (gate(_NOT_FINITE, 1, 0, "low", "pictures with NaN or infinity"),)
    if shared:
        notes += ("one is Radiance's .hdr: differences of 1/128 of a pixel's largest channel count as none",)
    notes += tuple(f"one is {said(kind)}" for kind in dict.fromkeys(kind for kind, _ in lossy))
    tolerance, times = tolerance_of(a, b, bits), 1.0
    if tolerance == FLOAT:
        times = brightening(b)
    if times != 1.0:
        a, b = (times * image for image in (a, b))
        scene = replace(scene, exposure=times) if scene else None
        notes += (f"the reference is dim: figures are of both {times:g} times as bright",)
    exact = b
    if tolerance != FLOAT:
        notes += tuple(
            f"{count} pixels of {name} are brighter than white, or below black, which the other's integers "
            "cannot hold; they count as white, or black"
            for name, image in (("the picture", a), ("the reference", b))
            if (count := off_screen(image))
        )
        a, b = (np.clip(image, 0.0, 1.0) for image in (a, b))
    if tolerance == BYTE:
        a, b = (decode(encode(image)) for image in (a, b))
    if a.shape != b.shape:
        gates: tuple[Gate, ...] = (Gate("size", 1.0, 0.0, False, "low", f"{size(a)} in place of {size(b)}"),)
        found = tuple(explain(a, b, tolerance))
        return PictureComparison("different", {}, gates, found, notes, wanted is not None)
    given = a
    for kind, right in lossy:
        a = told_apart(a, b, kind, right, times)
    mask = np.zeros(b.shape[:2], bool)
    if masked:
        mask = scene.edges(b) if scene else steep(b)
    metrics, gates = measured(a, b, mask, tolerance)
    if not all(gate.passed for gate in gates):
        rounded = measured(_unrounded(a, b, tolerance), b, mask, tolerance)[1]
        if all(gate.passed for gate in rounded):
            gates = rounded
            step = f"{tolerance * 255:g} steps of 8 bits" if tolerance == BYTE else f"{tolerance:.2g}"
            notes += (f"limits are held against what differs by more than rounding ({step})",)
    notes += tuple(filter(None, [without_flip()]))
    same = not finite and np.array_equal(picture, reference)
    verdict = _verdict(same, metrics, (*gates, *finite), tolerance)
    gates = (*(gates if wanted is None else asked(wanted, metrics)), *finite)
    if verdict in ("identical", "equal"):
        return PictureComparison(verdict, metrics, gates, (), notes, wanted is not None)
    budget = Budget(seconds)
    lost = ~(np.isfinite(picture).all(axis=-1) & np.isfinite(reference).all(axis=-1))
    rest = np.where(lost[..., None], b, given)  # what is not finite tells nothing of a mistake elsewhere
    if lost.any() and disagreement(np.where(lost[..., None], b, a), b, tolerance) == 0.0:
        causes = [Cause(_NOT_FINITE, "all that differs is NaN or infinite; elsewhere they agree", 0.0)]
    else:
        causes = _causes((rest, b, exact), mask, tolerance, scene, report, budget)
        causes = _beyond_loss(causes, (rest, b), lossy, tolerance, times)
    if budget.stopped:
        notes += (f"the search for causes stopped after {seconds:g} s; --seconds N lets it take N",)
    return PictureComparison(verdict, metrics, gates, tuple(causes), notes, wanted is not None)


def causes_between(
    picture: Array,
    reference: Array,
    mask: Array | None,
    tolerance: float,
    scene: SceneReference,
    seconds: float,
    bits: int = 32,
) -> tuple[Cause, ...]:
    """Why a picture is not its reference, another program's picture of the scene, the likeliest cause first.

    Both are linear (h, w, 3) and on the same footing (of 8 bits, or not); mask (h, w): edges, to be left out.
    bits: of a sample of the picture's file.
    """
    a = np.nan_to_num(picture, nan=0.0, posinf=0.0, neginf=0.0)
    times = brightening(reference) if tolerance == FLOAT else 1.0
    if times != 1.0:
        a, reference, scene = times * a, times * reference, replace(scene, exposure=times)
    if a.shape != reference.shape:
        return tuple(explain(a, reference, tolerance))
    mask = np.zeros(reference.shape[:2], bool) if mask is None else mask
    pictures = a, reference, reference
    causes = _causes(pictures, mask, tolerance, scene, None, Budget(seconds))
    lossy = [(bits, reference)] if bits in LOSSY else []
    return tuple(_beyond_loss(causes, (a, reference), lossy, tolerance))


def _beyond_loss(
    causes: list[Cause], pictures: tuple[Array, Array], lossy: list[_Lossy], tolerance: float,
    times: float = 1.0,
) -> list[Cause]:  # fmt: skip
    """Causes of pictures with lossy files: what a file may lose, pressed hard, is no object or shadow.

    times: how much brighter the pictures are than what was stored.
    """
    certain = [cause for cause in causes if cause.certain]
    if not lossy or (certain and len(certain) == len(causes)):
        return causes
    a, b = pictures
    for kind, right in lossy:
        a = told_apart(a, b, kind, right, _PRESSED * times)
    return [*certain, *([] if certain else regions(a, b, tolerance))]


def _causes(
    pictures: tuple[Array, Array, Array],
    mask: Array,
    tolerance: float,
    scene: SceneReference | None,
    report: Callable[[str], None] | None,
    budget: Budget,
) -> list[Cause]:
    """Causes for a picture and its reference, also as it was before 8 bits rounded it; [] for none."""
    a, b, exact = pictures
    causes = explain(a, b, tolerance)
    if scene and not any(_settles(cause) for cause in causes):
        causes = _causes_of_scene(causes, (a, exact), ~mask, tolerance, scene, report, budget)
    whole = scene.whole() if scene and not any(cause.proven for cause in causes) else None
    if whole and not (budget.over() or mask.any()):
        causes = [cause for cause in resized(a, whole.render(), tolerance) if cause.proven] or causes
    if not any(cause.proven for cause in causes):
        causes += regions(a, b, tolerance)
    return causes


def _settles(cause: Cause) -> bool:
    """Whether no scene needs to be searched: not where one of its lights may do what the cause does."""
    if cause.shades:
        return cause.left <= EXACT and cause.numbers == 1
    return cause.left <= NOTHING or (cause.proven and cause.name in _FINAL)


def _of_floats(bits: int) -> int:
    return 32 if bits in (SHARED_EXPONENT, HALF, *LOSSY) else bits


def _unrounded(a: Array, b: Array, tolerance: float) -> Array:
    """The first picture with the other's pixels where they differ by rounding only.

    FLIP sees half a step of 8 bits in a large even surface: bytes that are cut off, not rounded.
    """
    shown = extended if tolerance == FLOAT else encoded
    out = np.array(a)
    for part, other in zip(parts(out), parts(b), strict=True):
        near = largest(shown(part) - shown(other)) <= tolerance
        part[near] = other[near]
    return out


def _verdict(identical: bool, metrics: dict[str, float], gates: tuple[Gate, ...], tolerance: float) -> str:
    if identical:
        return "identical"
    if all(gate.passed for gate in gates):
        return "equal" if metrics["largest, of 255"] <= 255 * tolerance else "same picture"
    return "similar" if metrics["SSIM"] >= SIMILAR else "different"


def explain(picture: Array, reference: Array, tolerance: float) -> list[Cause]:
    """Causes that two linear pictures (h, w, 3) of any sizes tell by themselves, the best first.

    [] where they agree within the tolerance or nothing helps. Of large ones of one size the middle is asked.
    """
    if picture.shape == reference.shape:
        where = _middle(picture.shape)
        picture, reference = picture[where], reference[where]
    if picture.shape == reference.shape and disagreement(picture, reference, tolerance) == 0:
        return []
    tried: tuple[Cause, ...] = (
        *clipped(picture, reference, tolerance),
        *undoable(picture, reference, tolerance),
        *moved(picture, reference, tolerance),
        *resized(picture, reference, tolerance),
    )
    for fading, looks in faded(picture, reference, tolerance):
        tried += (fading, *_beside(fading, undoable(picture, looks, tolerance)))
    if not any(cause.proven for cause in tried):
        tried += tuple(compressed(picture, reference, tolerance))
    if not any(cause.proven for cause in tried):
        tried += tuple(recurved(picture, reference, tolerance))
    return ranked([cause for cause in tried if cause.likely or picture.shape != reference.shape])


def _beside(first: Cause, further: Iterable[Cause]) -> list[Cause]:
    """What `further` explains of what `first` leaves."""
    return [
        replace(
            more,
            name=f"{first.name} and {more.name}",
            text=f"{first.text}; {more.text}",
            left=more.left * first.left,
            numbers=more.numbers + first.numbers,
        )
        for more in further
        if more.proven
    ]


def _middle(shape: tuple[int, ...]) -> tuple[slice, ...]:
    """The middle of a picture, which any turn leaves there, in whole blocks of a JPEG."""
    starts = [max(0, (side - _LOOKED_AT) // 2 // 16 * 16) for side in shape[:2]]
    return tuple(slice(start, side - start) for start, side in zip(starts, shape[:2], strict=True))


def _causes_of_scene(
    causes: list[Cause],
    pictures: tuple[Array, Array],
    kept: Array,
    tolerance: float,
    scene: SceneReference,
    report: Callable[[str], None] | None,
    budget: Budget,
) -> list[Cause]:
    """`causes` and those found in the scene, in the picture as it is or with what is likely undone.

    Only the pixels in `kept` (h, w) count. Where pixels are moved or channels swapped, only with that undone.
    Where another cause explains all, only the shares of lights and the like are fitted, which is cheap.
    """

    def search(picture: Array, known: bool) -> list[Cause]:
        def render(changed: Scene, shadows: bool = True, layer: str = "") -> Array:
            return (scene.layer(changed, layer) if layer else scene.render(changed, shadows))[kept]

        pixels = picture[kept], scene.scene, reference[kept]
        return explain_by_scene(*pixels, render, tolerance, report, budget, known)

    picture, reference = pictures
    proven = [cause for cause in causes if cause.proven]
    moved = any(not (cause.shades or cause.blurs) for cause in proven)
    found = [] if moved else search(picture, any(cause.left <= NOTHING for cause in proven))
    # fewer numbers first, also where they leave much by themselves: with a factor of its own, too, shares of
    # lights explain what they explain without it
    undone = sorted(undoable(picture, reference, tolerance), key=lambda cause: cause.numbers)
    for cause in undone:
        if budget.over() or any(other.left <= NOTHING for other in (*proven, *found)):
            break
        likelier = cause.proven or not any(other.proven for other in found)
        if cause.undone is not None and likelier and (cause.left < 0.9 or undone[-1].left < 0.9):
            found += _beside(cause, search(cause.undone, False))
    return ranked([*causes, *found])


def regions(picture: Array, reference: Array, tolerance: float) -> list[Cause]:
    """What can be said of pictures that agree except in places: a missing shadow, light or object.

    Not certain: what is tested is that the pictures agree elsewhere and that all the places differ one way.
    """
    from scipy import ndimage

    difference, lighter = np.empty(picture.shape[:2]), np.empty(picture.shape[:2], bool)
    for block, _ in blocks(picture.shape, 0):
        part = extended(picture[block]) - extended(reference[block])
        # of the channel that differs most: another colour may be as bright as the right one
        difference[block], lighter[block] = largest(part), part.sum(axis=-1) > 0
    # what is less than two pixels wide is an edge that two correct programs draw differently
    places = ndimage.binary_opening(difference > 4 * tolerance, np.ones((2, 2)))
    labels, count = ndimage.label(places)
    brighter = share(lighter[places])
    one_way = not 0.03 <= brighter <= 0.97
    if not count or share(places) > (_LARGEST_PLACES if one_way else 0.5):
        return []
    beyond = np.maximum(difference - tolerance, 0)
    elsewhere = float(beyond[~places].sum() / beyond.sum())
    sizes = ndimage.sum_labels(places, labels, range(1, count + 1))
    rows, columns = ndimage.find_objects(labels)[int(np.argmax(sizes))]
    box = f"{columns.stop - columns.start} x {rows.stop - rows.start}"
    box = f"{box} pixels at ({columns.start}, {rows.start})"
    name, way = "an object that differs", "differs"
    if one_way and brighter > 0.5:
        name, way = "a missing shadow, or light that should not be", "is brighter"
    elif one_way:
        name, way = "a missing light, or a shadow that should not be", "is darker"
    where = f"{count} place{'s' if count > 1 else ''}, the largest {box}, {100 * share(places):.1f} % in all,"
    text = f"it {way} in {where} and agrees elsewhere; compare with the scene to be sure"
    cause = Cause(name, text, elsewhere, certain=False)
    return [cause] if cause.likely else []
