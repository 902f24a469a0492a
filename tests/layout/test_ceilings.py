"""What the kernels can hold, whatever `Limits` allows: each is reached, and one beyond is an error."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import clrt
from clrt import layout
from clrt.base.layers import check_layers
from clrt.base.limits import Limits
from clrt.layout import ceilings
from clrt.scene.arealights import MOST_SAMPLES

CAMERA = {"origin": [0, 0, 5], "target": [0, 0, 0], "width": 4, "height": 3}
BALL = {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": {"diffuse": 0.8}}
MORE = Limits(**dict.fromkeys(("lights", "depth", "bands", "pixels", "samples", "primitives"), 1 << 62))
SETTINGS = clrt.Settings(limits=Limits(**{**vars(MORE), "work": 1 << 200, "device_bytes": 1 << 32}))


def render(table: dict[str, Any], **how: Any) -> clrt.Image:
    scene = clrt.load_dict({"camera": CAMERA, "shapes": [BALL], **table}, limits=MORE)
    return clrt.render(scene, settings=SETTINGS, **how)


def lit_by(lights: int) -> clrt.Image:
    one = {"type": "directional", "direction": [0, 0, -1], "intensity": 1 / lights}
    return render({"lights": [one] * lights})


def test_fields_of_the_packed_words_fill_their_bits_and_do_not_overlap() -> None:
    fields = [bits for name, bits in layout.SPAWN.items() if name != "SPAWN_GROUP"]
    assert sum(fields) == (1 << 29) - 1 == int(np.bitwise_or.reduce(fields))
    assert layout.SPAWN["SPAWN_GROUPS"] % layout.SPAWN["SPAWN_GROUP"] == 0
    flags = sum(bits for name, bits in layout.SURFACE.items() if name != "SURFACE_MATERIAL")
    assert flags < layout.SURFACE["SURFACE_MATERIAL"]


def test_sums_over_a_chunk_fit_a_word() -> None:
    """`count` adds up a chunk's items in 32 bits."""
    for most in (ceilings.LIGHTS, ceilings.GROUPS, ceilings.AMBIENT):
        assert layout.CHUNK * most < 1 << 32
    with pytest.raises(clrt.SceneError, match="ambient_samples"):
        clrt.load_dict({"ambient_samples": ceilings.AMBIENT + 1})


def test_the_usual_limits_are_within_the_ceilings() -> None:
    usual = Limits()
    assert usual.lights == ceilings.LIGHTS == MOST_SAMPLES
    assert usual.depth <= ceilings.DEPTH and usual.primitives <= ceilings.PRIMITIVES
    assert usual.pixels <= ceilings.PIXELS and usual.samples <= ceilings.RAYS
    assert usual.bands <= min(ceilings.BANDS, ceilings.GROUPS)


def test_as_many_lights_as_the_feelers_bits_count() -> None:
    image, single = lit_by(ceilings.LIGHTS), lit_by(1)
    assert image.stats["rays"]["feelers"] == ceilings.LIGHTS * single.stats["rays"]["feelers"] > 0
    np.testing.assert_allclose(image.pixels, single.pixels, rtol=2e-3)  # a sum of 65 535 float32
    with pytest.raises(
        clrt.LimitError, match=r"lights: 65 536 is too many: 65 535 is the most .*fewer lights"
    ):
        lit_by(ceilings.LIGHTS + 1)
    with pytest.raises(clrt.LimitError, match="lights: 65 536 is above the limit"):
        clrt.load_dict({"lights": [{"type": "point", "position": [0, 0, 0]}] * 65_536})


def dispersed(bands: int, group: int = 1) -> clrt.Image:
    glass = {"diffuse": 0, "transmission": 1, "ior": "BK7"}
    return render(
        {
            "spectrum": {"bands": bands, "group": group},
            "background": 1,
            "shapes": [{**BALL, "material": glass}],
        },
        max_depth=2,
    )


def test_as_many_dispersion_groups_as_their_bits_count() -> None:
    image, fewer = dispersed(ceilings.GROUPS), dispersed(ceilings.GROUPS * 2, 2)
    first, hits = image.stats["generations"][:2][1], image.stats["rays"]["camera_hits"]
    assert first["transmission"] == ceilings.GROUPS * hits > 0
    assert fewer.stats["generations"][1]["transmission"] == first["transmission"]
    np.testing.assert_allclose(image.pixels, dispersed(24).pixels, rtol=0.02)
    for bands, group in ((ceilings.GROUPS + 1, 1), (2 * ceilings.GROUPS + 1, 2)):
        with pytest.raises(clrt.LimitError, match="dispersion groups: 128 is too many: 127 is the most"):
            dispersed(bands, group)


@pytest.mark.parametrize("local_size", [None, 4096])
def test_as_many_bands_as_private_memory_holds(local_size: int | None) -> None:
    """A work-group's private arrays lie on a thread's stack: more work-items a group leave room for fewer."""
    for bands in (3, 64, ceilings.BANDS):
        scene = clrt.load_dict(
            {"camera": CAMERA, "shapes": [BALL], "ambient": 1, "spectrum": {"bands": bands}}, limits=MORE
        )
        settings = clrt.Settings(local_size=local_size, limits=SETTINGS.limits)
        pixels = clrt.render(scene, settings=settings).pixels
        assert pixels.max() > 0.5 and np.isfinite(pixels).all()
    with pytest.raises(clrt.LimitError, match="bands: 8 193 is too many"):
        render({"spectrum": {"bands": ceilings.BANDS + 1}})


def test_as_many_media_as_a_list_has_places() -> None:
    glass = {"diffuse": 0, "transmission": 1, "ior": 1.1}

    def nested(media: int) -> clrt.Image:
        return render(
            {
                "shapes": [{**BALL, "radius": 1 + 0.1 * k, "material": glass} for k in range(media)],
                "background": 1,
            },
            max_depth=20,
        )

    np.testing.assert_allclose(nested(layout.MEDIA).pixels, 1, rtol=1e-5)
    with pytest.raises(clrt.LimitError, match="more than 8 media"):
        nested(layout.MEDIA + 1)


def test_as_many_generations_as_a_scene_may_have() -> None:
    table = {"lights": [{"type": "point", "position": [0, 0, 5]}]}
    names = [f"generation_{ceilings.DEPTH}", "generation_0"]
    image = render(table, max_depth=ceilings.DEPTH, layers=names)
    assert image.layers["generation_0"].max() > 0 and not image.layers[names[0]].any()
    for depth in (ceilings.DEPTH + 1, 10**18, 10**400):
        with pytest.raises(
            clrt.LimitError, match=r"depth: .* (is too many: 65 536 is the most|above the limit)"
        ):
            render(table, max_depth=depth)
    assert check_layers(["generation_999999"], 10**18) == ("generation_999999",)
    with pytest.raises(clrt.ClrtError, match="'generation_7' is not a layer"):
        check_layers(["generation_7"], 6)


def test_as_many_pixels_as_have_numbers() -> None:
    """The last pixel of the largest picture has the number 2^32 - 2."""
    table = {"lights": [{"type": "directional", "direction": [0, 0, -1]}], "shapes": [{**BALL, "radius": 4}]}
    size = {"width": 65535, "height": 65537}
    last, first = (render(table, **size, crop=crop) for crop in ((65534, 65536, 1, 1), (0, 0, 1, 1)))
    assert last.pixels.shape == (1, 1, 3) and last.pixels.max() > 0
    np.testing.assert_allclose(last.pixels, first.pixels, rtol=1e-3)  # the ball is as far from every corner
    with pytest.raises(clrt.LimitError, match="pixels: 4 294 967 296 is too many: 4 294 967 295 is the most"):
        render({}, width=65536, height=65536, crop=(0, 0, 1, 1))


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"spp": 10**20}, "samples: .* is too many"),
        ({"spp": 10**400}, "samples: .* is too many"),
        ({"spp": 46341**2}, "samples: 2 147 488 281 is too many"),
        ({"width": 1 << 31}, "width: 2147483648 is not allowed"),
        ({"width": 1 << 30}, "height: 35184372088832 is not allowed"),
        ({"height": 10**400}, "height: 1000.* is not allowed"),
    ],
)
def test_pictures_that_no_record_can_say_are_refused(how: dict[str, int], words: str) -> None:
    camera = {**CAMERA, "width": 2, "height": 65536}
    with pytest.raises(clrt.ClrtError, match=words):
        render({"camera": camera}, **how)


def test_checks_stand_at_their_ceilings() -> None:
    """Those that no test can reach: they would need more memory than machines have."""
    for name, most in (("primitives", ceilings.PRIMITIVES), ("materials", ceilings.MATERIALS)):
        ceilings.check(name, most, most)
        with pytest.raises(clrt.LimitError, match=f"^scene.toml: {name}: .* is too many"):
            ceilings.check(name, most + 1, most, "scene.toml")
    assert ~(ceilings.PRIMITIVES * 4 + 3) >= -(1 << 31)  # a leaf's reference
    assert 8 * ceilings.PRIMITIVES < 1 << 31  # places of leaves of other kinds
    assert 2 * ceilings.PRIMITIVES + 64 < 1 << 31  # nodes of the builder
    word = (ceilings.MATERIALS - 1) * layout.SURFACE["SURFACE_MATERIAL"] + 7
    assert word < 1 << 31
    ceilings.check_picture(ceilings.PIXELS, ceilings.RAYS)


def test_layers_and_answers_have_a_limit_of_host_memory() -> None:
    scene = clrt.load_dict({"camera": CAMERA, "shapes": [BALL]})
    layers = ["depth", "normal", "direct"]
    needs = 4 * 4 * 3 * (3 + 1 + 1 + 3 + 3)  # picture, numbers, layers
    clrt.render(scene, layers=layers, settings=clrt.Settings(limits=Limits(host_bytes=needs)))
    tight = clrt.Settings(limits=Limits(host_bytes=needs - 1))
    with pytest.raises(
        clrt.LimitError, match=r"host_bytes: 528 is above .*fewer layers.*--limit host_bytes=N"
    ):
        clrt.render(scene, layers=layers, settings=tight)
    clrt.render(scene, layers=layers, settings=tight, crop=(0, 0, 4, 2))
    names = ["direct", "reflection", "transmission", "ambient", "emission", "diffuse", "highlight", "normal"]
    with pytest.raises(clrt.LimitError, match="host_bytes"):  # before any of its 15 GB is asked for
        clrt.render(scene, width=16384, height=8192, layers=names)
    tracer = clrt.Tracer(scene, settings=clrt.Settings(limits=Limits(host_bytes=320)))
    o, d = np.zeros((11, 3)), np.ones((11, 3))
    tracer.intersect(o[:10], d[:10])
    for ask in (tracer.intersect, lambda o, d: tracer.occluded(np.tile(o, (30, 1)), np.tile(d, (30, 1)))):
        with pytest.raises(clrt.LimitError, match=r"rays: host_bytes: .* fewer rays"):
            ask(o, d)
    same = np.broadcast_to(np.float32(1), (10**11, 3))  # of 4 bytes, and 1.2 TB as rays
    for many in (tracer.intersect, tracer.occluded, tracer.radiance, tracer.all_hits, tracer.count_hits):
        with pytest.raises(clrt.LimitError, match=r"rays: host_bytes: "):
            many(same, same)


def test_work_groups_are_as_large_as_the_device_takes_them() -> None:
    """A device may take one work-item a group only."""
    script = "import clrt; print(clrt.render('bubble', width=16).hash)"
    usual = clrt.render("bubble", width=16).hash
    environment = {**os.environ, "POCL_MAX_WORK_GROUP_SIZE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=300
    )
    assert (done.stdout.strip(), done.returncode) == (usual, 0), done.stderr
