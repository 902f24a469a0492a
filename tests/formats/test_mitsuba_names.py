"""Of what Mitsuba has, nothing is told not to be there: asked of the Mitsuba that is installed."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import clrt
from clrt.base.errors import ClrtWarning
from tests.mitsuba_samples import BALL, lost, read

_ASK = """
import json, pathlib, re
import mitsuba as mi
mi.set_variant("scalar_rgb")
kinds = {kind.name: [] for kind in mi.ObjectType}
home = pathlib.Path(mi.__file__).parent
for file in sorted((home / "plugins").iterdir()):
    kinds[mi.PluginManager.instance().plugin_type(file.stem).name].append(file.stem)
text = "".join(file.read_text("utf-8") for file in (home / "python/ad/integrators").glob("*.py"))
kinds["Integrator"] += re.findall(r'register_integrator\\("(\\w+)"', text)
print(json.dumps(kinds))
"""
VIEW = '<sensor type="perspective">{}</sensor>'
TEXTURE = BALL.format('<bsdf type="diffuse">{}</bsdf>')
PLACES = {
    "BSDF": ("bsdf", BALL), "Shape": ("shape", "{}"), "Emitter": ("emitter", "{}"),
    "Texture": ('texture name="reflectance"', TEXTURE), "Sensor": ("sensor", "{}"), "Film": ("film", VIEW),
    "ReconstructionFilter": ("rfilter", VIEW.format('<film type="hdrfilm">{}</film>')),
    "Integrator": ("integrator", "{}"), "Sampler": ("sampler", VIEW), "Medium": ("medium", "{}"),
    "PhaseFunction": ("phase", "{}"), "Volume": ("volume", "{}"),
}  # fmt: skip
"""By Mitsuba's word for a kind: its tag, and where it stands."""


@pytest.fixture(scope="module")
def plugins() -> dict[str, list[str]]:
    """Mitsuba's names by kind; from a process of its own, since those that cannot load it end theirs."""
    pytest.importorskip("mitsuba")
    done = subprocess.run([sys.executable, "-c", _ASK], capture_output=True, text=True, check=True)
    found: dict[str, list[str]] = json.loads(done.stdout)
    return {kind: names for kind, names in found.items() if names}


@pytest.mark.parametrize("kind", PLACES)
def test_no_plugin_of_mitsuba_is_told_not_to_be_there(
    kind: str, plugins: dict[str, list[str]], tmp_path: Path
) -> None:
    assert plugins.keys() == PLACES.keys()
    tag, place = PLACES[kind]
    for name in plugins[kind]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ClrtWarning)
            try:
                read(tmp_path, place.format(f'<{tag} type="{name}"/>'))
            except clrt.ClrtError as error:  # of some plugins Mitsuba asks for more, too
                assert "there is no" not in str(error), name


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ('<emitter type="timed_sunsky"/>', "the emitter timed_sunsky"),
        ('<emitter type="area"/>', "the emitter area"),
        (BALL.format('<bsdf type="measured_polarized"/>'), "the bsdf measured_polarized"),
        (TEXTURE.format('<texture name="reflectance" type="volume"/>'), "the texture volume"),
        ('<shape type="blender"/>', "the shape blender"),
        (
            BALL.format(
                '<bsdf type="twosided"><boolean name="allow_transmission" value="true"/>'
                '<bsdf type="diffuse"/></bsdf>'
            ),
            "allow transmission of twosided",
        ),
    ],
)
def test_what_it_has_and_clrt_has_not_is_named(body: str, named: str, tmp_path: Path) -> None:
    assert named in lost(tmp_path, body)


@pytest.mark.parametrize(
    ("integrator", "depth"),
    [("prb_basic", 3), ("prbvolpath", 3), ("prb_projective", 3), ("direct_projective", 0),
     ("volprim_rf_basic", None)],
)  # fmt: skip
def test_depths_of_integrators_in_python(integrator: str, depth: int | None, tmp_path: Path) -> None:
    body = f'<integrator type="{integrator}"><integer name="max_depth" value="5"/></integrator>'
    assert read(tmp_path, body).to_dict().get("max_depth") == depth


def test_a_constant_sky_may_be_turned(tmp_path: Path) -> None:
    """It is the same from everywhere."""
    turn = '<transform name="to_world"><rotate y="1" angle="30"/></transform>'
    assert read(tmp_path, f'<emitter type="constant">{turn}</emitter>').background == 1.0
