"""Mitsuba's XML, good and spoiled: values, parts too many or nested, words that XML has for other things."""

from __future__ import annotations

import random
import re
from typing import Final

from .sizes import count
from .values import NUMBERS, WORDS

SCENE: Final = """\
<?xml version="1.0" encoding="utf-8"?>
<scene version="3.0.0">
  <default name="depth" value="6"/>
  <integrator type="path"><integer name="max_depth" value="$depth"/></integrator>
  <sensor type="thinlens">
    <float name="fov" value="40"/><string name="fov_axis" value="smaller"/>
    <float name="aperture_radius" value="0.05"/><float name="focus_distance" value="5"/>
    <transform name="to_world"><lookat origin="0, 1, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="9"/>
      <rfilter type="tent"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
  </sensor>
  <bsdf type="twosided" id="wall"><bsdf type="diffuse">
    <rgb name="reflectance" value="0.7, 0.5, 0.3"/></bsdf></bsdf>
  <bsdf type="blendbsdf" id="shiny"><float name="weight" value="0.3"/><ref id="wall"/>
    <bsdf type="roughconductor"><string name="material" value="Au"/>
      <float name="alpha" value="0.2"/></bsdf></bsdf>
  <bsdf type="dielectric" id="glass">
    <string name="int_ior" value="bk7"/><float name="ext_ior" value="1"/></bsdf>
  <shape type="sphere">
    <point name="center" x="0" y="0.5" z="0"/><float name="radius" value="0.5"/><ref id="glass"/>
  </shape>
  <shape type="cube"><transform name="to_world"><scale value="0.3"/><rotate y="1" angle="30"/>
    <translate x="1" y="0.3"/></transform><ref id="shiny"/></shape>
  <shape type="rectangle"><transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.9"/>
      <transform name="to_uv"><scale x="4" y="4"/></transform></texture></bsdf></shape>
  <shape type="disk"><transform name="to_world"><rotate x="1" angle="90"/><translate y="4"/></transform>
    <emitter type="area"><rgb name="radiance" value="5 5 4"/></emitter></shape>
  <emitter type="spot"><spectrum name="intensity" value="400:3, 700:5"/>
    <float name="cutoff_angle" value="30"/>
    <transform name="to_world"><lookat origin="2, 3, 2" target="0, 0, 0" up="0, 1, 0"/></transform></emitter>
  <emitter type="constant"><rgb name="radiance" value="0.1"/></emitter>
</scene>
"""
_TAGS: Final = ("scene", "shape", "bsdf", "emitter", "sensor", "texture", "ref", "default", "include",
                "transform", "float", "rgb", "string", "alias", "lookat", "x", "\u202e")  # fmt: skip
_TYPES: Final = ("sphere", "disk", "ply", "obj", "blendbsdf", "twosided", "mask", "principled", "plastic",
                 "bitmap", "envmap", "orthographic", "area", "serialized", "difuse", "")  # fmt: skip
_IDS: Final = ("wall", "shiny", "glass")
_BOMB: Final = '<!DOCTYPE x [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;">]>'
_OUTSIDE: Final = '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
_ATTRIBUTE: Final = re.compile(r'(\w+)="([^"]*)"')


def spoil(draw: random.Random, text: str) -> str:
    """One change of a file's meaning."""
    return draw.choice(_CHANGES)(draw, text)


def _value(draw: random.Random, text: str) -> str:
    """The value of an attribute, or a part of it."""
    found = draw.choice([*_ATTRIBUTE.finditer(text)])
    others = [*map(str, NUMBERS), *_TYPES, "$depth", "$nothing", "../x.ply", "/dev/zero", *_IDS]
    new = draw.choice(others) if draw.random() < 0.8 else draw.choice(WORDS).decode("latin-1")
    return text[: found.start(2)] + new.replace('"', "") + text[found.end(2) :]


def _name(draw: random.Random, text: str) -> str:
    """The name of an attribute or of a tag."""
    if draw.random() < 0.5:
        found = draw.choice([*_ATTRIBUTE.finditer(text)])
        new = draw.choice(("name", "value", "x", "id", "type"))
        return text[: found.start(1)] + new + text[found.end(1) :]
    old = draw.choice(re.findall(r"<(\w+)", text))
    return re.sub(rf"(</?){old}\b", rf"\g<1>{draw.choice(_TAGS)}", text)


def _repeated(draw: random.Random, text: str) -> str:
    """A line many times, or within itself."""
    lines = text.splitlines()
    at = draw.randrange(2, len(lines))
    lines[at:at] = [lines[at]] * count(draw, len(lines[at]))
    return "\n".join(lines)


def _nested(draw: random.Random, text: str) -> str:
    many, tag = draw.choice((3, 20, 3000)), draw.choice(_TAGS[:-1])
    inner = f'<{tag} type="twosided" name="a" value="$depth" id="glass">' * many + f"</{tag}>" * many
    return text.replace("</scene>", f"{inner}</scene>")


def _entities(draw: random.Random, text: str) -> str:
    """A document type, with entities that grow or name files; parameters that grow."""
    if draw.random() < 0.4:
        doubled = "".join(f'<default name="a{k}" value="$a{k - 1}$a{k - 1}"/>' for k in range(1, 60))
        return text.replace('value="6"/>', f'value="6"/><default name="a0" value="99"/>{doubled}', 1)
    kind = draw.choice((_BOMB, _OUTSIDE))
    used = draw.choice(('"&c;"', '"&a;"', '"path"'))
    return text.replace("<scene", f"{kind}<scene", 1).replace('"path"', used, 1)


def _references(draw: random.Random, text: str) -> str:
    """Materials that are made of one another."""
    many = draw.choice((1, 2, 60))
    made = "".join(
        f'<bsdf type="blendbsdf" id="b{k}"><ref id="b{(k + 1) % many}"/><ref id="b{(k + 1) % many}"/></bsdf>'
        for k in range(many)
    )
    others = ("<ref/>", '<include filename="scene.xml"/>', '<alias id="b0" as="b1"/>')
    last = draw.choice(('<ref id="b0"/>', *others))
    return text.replace("</scene>", f"{made}{last}</scene>")


def _instruction(draw: random.Random, text: str) -> str:
    """What only clrt writes: a seal that does not fit, or none, with a scene of any kind."""
    words = draw.choice(('{"shapes": []}', "0" * 64 + " {}", "[" * 5000, "", '{"background": "/dev/zero"}'))
    return text.replace("</scene>", f"<?clrt {words}?></scene>")


_CHANGES: Final = (_value, _value, _value, _value, _name, _name, _repeated, _nested, _entities, _references,
                   _instruction)  # fmt: skip
