"""The benchmark of bands: its pictures show what they are said to, its ratios are those of the times."""

from __future__ import annotations

import clrt
from clrt.bench import bands, timing
from clrt.bench.timing import Case, Measurement


def test_the_ball_of_glass_disperses_in_one_of_its_pictures():
    """And it covers the 8 % of the picture for which its price is published."""
    rays = {
        how: clrt.render(scene, width=64, layers=["shape"])
        for shown, how, scene in bands.pictures(quick=True)
        if shown == "glass ball" and how not in bands.GROUPS
    }
    one, alike, dispersed = (
        rays[how].stats["rays"]["transmission"] for how in (bands.ONE, bands.ALIKE, bands.DISPERSED)
    )
    assert one == alike > 0
    assert 0.9 * bands.MOST * one < dispersed < 1.1 * bands.MOST * one
    assert 0.07 < (rays[bands.ONE].layers["shape"] == 2).mean() < 0.09


def test_groups_of_bands_say_how_far_they_are_from_single_ones():
    """The fewer rays, the more values are others."""
    made = {m.name: m for m in bands.times(1, None, clrt.Settings(), quick=True)}
    apart = [made[name].extra["apart"] for name in bands.GROUPS]
    assert 0 < apart[0] < apart[1] < apart[2] < 0.05
    assert "apart" not in made[bands.DISPERSED].extra
    scenes = {name: scene for _, name, scene in bands.pictures(quick=True)}
    rays = [
        clrt.render(scenes[name], width=64).stats["rays"]["transmission"]
        for name in (bands.DISPERSED, list(bands.GROUPS)[1])
    ]
    assert 7 < rays[0] / rays[1] < 9, "a ray for eight bands"


def test_bands_cost_what_they_cost_against_rgb_or_one_wavelength():
    def made(shown: str, how: str, seconds: float) -> Measurement:
        return timing.measured(Case(group="bands", scene=shown, name=how, run=lambda: None), (seconds,))

    times = [made("flake", "RGB", 2.0), made("flake", "8 bands", 3.0)]
    times += [made("glass ball", bands.ONE, 0.5), made("glass ball", bands.DISPERSED, 4.0)]
    assert bands.ratio(times, "flake", "8 bands") == 1.5
    assert bands.ratio(times, "glass ball", bands.DISPERSED) == 8.0
