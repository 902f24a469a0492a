"""A small scene to look at, whose texts are hostile, and questions to its server."""

from __future__ import annotations

import http.client
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import clrt
from clrt.view.server import Server
from clrt.view.session import Session

EVIL = "</script><script>window.evil = 1</script><img src=x onerror='window.evil = 2'>"
SIZE = (32, 24)
SCENE: dict[str, Any] = {
    "camera": {"origin": [0, 1, 5], "target": [0, 0, 0], "width": SIZE[0], "height": SIZE[1]},
    "lights": [{"type": "point", "position": [3, 5, 3], "intensity": [1.5, 1, 1]}],
    "background": [0.1, 0.2, 0.4],
    "max_depth": 3,
    "materials": {
        EVIL: {"color": [0.8, 0.3, 0.2], "specular": 0.4, "reflection": 0.5, "diffuse": 0.5},
        'with "quotes"': {},
        "floor": {"color": {"type": "checker", "colors": [0.9, 0.1]}},
    },
    "shapes": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "name": EVIL, "material": EVIL},
        {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": "floor"},
        {"type": "sphere", "center": [1.5, -0.5, 1], "radius": 0.5, "material": {"diffuse": 0.7}},
    ],
}


def scene() -> clrt.Scene:
    return clrt.load_dict(SCENE, source=f"{EVIL}.toml")


@contextmanager
def serving(session: Session) -> Iterator[Server]:
    with Server(session) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def request(
    server: Server, method: str, path: str, body: bytes | None = None, **headers: str | None
) -> tuple[int, dict[str, str], bytes]:
    """Status, headers, body. Host, Origin and Content-Type are right unless given; None: not sent."""
    sent = {"Host": server.authority, "Origin": server.origin, "Content-Type": "application/json"}
    if body is not None:
        sent["Content-Length"] = str(len(body))
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in {**sent, **given}.items():
        for one in (value or "").split("\n") if value is not None else ():
            connection.putheader(name, one)
    connection.endheaders(body)
    answer = connection.getresponse()
    found = answer.status, dict(answer.getheaders()), answer.read()
    connection.close()
    return found


def unpacked(data: bytes) -> tuple[dict[str, Any], bytes]:
    end = 4 + int.from_bytes(data[:4], "little")
    return json.loads(data[4:end]), data[end:]


def ask(server: Server, kind: str, **body: Any) -> tuple[dict[str, Any], bytes]:
    status, _, data = request(server, "POST", f"/{server.token}/{kind}", json.dumps(body).encode())
    assert status == 200, (status, data)
    return unpacked(data)
