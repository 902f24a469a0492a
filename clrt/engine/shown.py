"""A tracer as notebooks show it where nothing lives: a small picture of its scene, and what is in that."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Final
from xml.etree.ElementTree import Element, SubElement

from clrt.base.errors import ClrtError
from clrt.scene.summary import html, summary

if TYPE_CHECKING:
    from clrt.engine.tracer import Tracer

_WIDE: Final = 320  # pixels in a row


def shown(tracer: Tracer) -> str:
    """The HTML, without a picture where there is no camera or it cannot be rendered."""
    top = summary(tracer.scene)
    camera = tracer.scene.camera
    if camera is not None:
        try:
            picture = tracer._preview(min(_WIDE, camera.width))
        except ClrtError as error:
            SubElement(top, "p").text = f"no picture: {error}"
        else:
            data = base64.b64encode(picture._repr_png_()).decode()
            image = Element("img", {"alt": "the scene", "src": f"data:image/png;base64,{data}"})
            top.insert(1, image)
    SubElement(top, "p").text = f"on {tracer.device.info.label}"
    return html(top)
