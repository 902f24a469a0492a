"""The JSON schema of scene files, for editors. `python -m clrt.schema` writes it anew.

In a TOML file the first line `#:schema scene.schema.json` names it (for editors with Taplo, such as VS Code
with "Even Better TOML"), in a JSON file the key `"$schema": "scene.schema.json"`; both take a path or an
address.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec

from clrt.explain import describe
from clrt.records import Color
from clrt.scene import Document

SCHEMA_FILE = Path(__file__).with_name("scene.schema.json")


def schema() -> dict[str, Any]:
    """The JSON schema of scene files; `clrt/scene.schema.json` is this."""
    made = msgspec.json.schema(Document, schema_hook=lambda kind: {})
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "A clrt scene"}
    document = made["$defs"].pop("Document")
    for key in ("title", "description"):
        document.pop(key)
    document["properties"]["$schema"] = {"type": "string"}
    scene: dict[str, Any] = _greys_from_zero(head | document | {"$defs": made["$defs"]})
    return scene


def _greys_from_zero(node: Any) -> Any:
    """The schema with the one range that `Color` cannot state to msgspec."""
    if isinstance(node, list):
        return [_greys_from_zero(item) for item in node]
    if not isinstance(node, dict):
        return node
    made = {key: _greys_from_zero(value) for key, value in node.items()}
    if made.get("description") == describe(Color, ""):
        made["anyOf"] = [
            {**kind, "minimum": 0} if kind == {"type": "number"} else kind for kind in made["anyOf"]
        ]
    return made


def schema_text() -> str:
    """What `SCHEMA_FILE` holds."""
    return json.dumps(schema(), indent=1) + "\n"


if __name__ == "__main__":
    SCHEMA_FILE.write_text(schema_text(), "utf-8")
