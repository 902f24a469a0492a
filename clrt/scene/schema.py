"""The JSON schema of scene files, for editors. `python -m clrt.scene.schema` writes it anew.

In a TOML file the first line `#:schema scene.schema.json` names it (for editors with Taplo, such as VS Code
with "Even Better TOML"), in a JSON file the key `"$schema": "scene.schema.json"`; both take a path or an
address.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import msgspec

from clrt.scene.scene import Document

SCHEMA_ID: Final = "urn:uuid:cb22609a-8dbe-4bf7-a02c-49b0179bedef"
"""By which other schemas can refer to this one, of scenes of `version = 1`. Nobody serves it: no address."""
SCHEMA_FILE = Path(__file__).with_name("scene.schema.json")


def schema() -> dict[str, Any]:
    """The JSON schema of scene files; `clrt/scene/scene.schema.json` is this."""
    made = msgspec.json.schema(Document, schema_hook=lambda kind: {})
    dialect = "https://json-schema.org/draft/2020-12/schema"
    head = {"$schema": dialect, "$id": SCHEMA_ID, "title": "A clrt scene"}
    document = made["$defs"].pop("Document")
    for key in ("title", "description"):
        document.pop(key)
    document["properties"]["$schema"] = {"type": "string"}
    scene: dict[str, Any] = _short_forms(head | document | {"$defs": made["$defs"]})
    return scene


def _short_forms(node: Any) -> Any:
    """The schema with what `Colored.prepared` accepts besides, and the range msgspec cannot be told of."""
    if isinstance(node, list):
        return [_short_forms(item) for item in node]
    if not isinstance(node, dict):
        return node
    made = {key: _short_forms(value) for key, value in node.items() if key != "discriminator"}
    if made.get("title") == "Spectrum":
        made["required"] = []  # its type goes without saying
    if made.get("title") == "Camera":
        made["anyOf"] = [{"required": ["origin", "target"]}, {"required": ["pose"]}]
    kinds = made.get("anyOf", ())
    if {"$ref": "#/$defs/Spectrum"} in kinds:
        made["anyOf"] = [{**kind, "minimum": 0} if kind == {"type": "number"} else kind for kind in kinds]
        made["anyOf"].append({"type": "array", "minItems": 2, "items": _PAIR})
    return made


_PAIR = {
    "type": "array", "minItems": 2, "maxItems": 2,
    "prefixItems": [{"type": "number"}, {"type": "number"}], "items": False,
}  # fmt: skip


def schema_text() -> str:
    """What `SCHEMA_FILE` holds."""
    return json.dumps(schema(), indent=1) + "\n"


if __name__ == "__main__":
    SCHEMA_FILE.write_text(schema_text(), "utf-8")
