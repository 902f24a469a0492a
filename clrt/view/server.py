"""One page on 127.0.0.1, for who has its address and for no other page.

The address holds a secret that every request repeats (its paths are relative). A page of another site can
neither know it nor reach the server by a name that leads here: Host and, where a browser says it, Origin have
to be this server's to the letter (DNS rebinding: Jackson et al. 2007). Nothing is told to others (no Referer)
or taken from them (the content security policy).
"""

from __future__ import annotations

import errno
import hmac
import json
import secrets
import select
import socket
import sys
import threading
import time
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import TCPServer
from typing import Any, Final

from clrt.base.errors import NO_MEMORY, ClrtError, exhausted, legible
from clrt.base.log import log
from clrt.view.session import Answer, Session, answered
from clrt.view.web import module, page, style

HOST: Final = "127.0.0.1"
_BODY: Final = 1 << 20  # bytes of a question
_CONNECTIONS: Final = 32  # at once; a browser holds 6
_PAUSE: Final = 0.1  # seconds until one is asked for again
_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'"
)
_HEADERS: Final = {
    "Content-Security-Policy": _POLICY, "Referrer-Policy": "no-referrer", "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff", "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin", "Cross-Origin-Opener-Policy": "same-origin",
}  # fmt: skip


class Server(ThreadingHTTPServer):
    """Listens at once; `serve_forever` answers. port: 0 for a free one; ClrtError where it cannot be had."""

    daemon_threads = True
    request_queue_size = 128  # that connect at once; of more each waits a second or more

    def __init__(self, session: Session, port: int = 0) -> None:
        self.session = session
        self.token = secrets.token_urlsafe(24)
        self._ticket: str | None = secrets.token_urlsafe(24)
        self._tickets = threading.Lock()
        self._open: dict[socket.socket, bool] = {}  # the oldest first; has it said the token?
        self._opening = threading.Lock()
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise ClrtError(
                    f"--port {port}: is in use; name another one, or none: a free one is found"
                ) from None
            reason = error.strerror or error
            raise ClrtError(f"--port {port}: cannot be had ({reason}); name another one, or none") from None
        self.authority = f"{HOST}:{self.server_port}"
        self.origin = f"http://{self.authority}"

    def server_bind(self) -> None:
        TCPServer.server_bind(self)  # HTTPServer's asks the network for this machine's name
        self.server_name, self.server_port = HOST, self.server_address[1]

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"{self.origin}/{self.token}/"

    @property
    def ticket(self) -> str:
        """An address that leads to the page once: the command line of a browser is nobody's secret."""
        return f"{self.origin}/{self._ticket}/"

    def take_ticket(self, word: str) -> bool:
        """Whether it is the ticket; from then on nothing is."""
        with self._tickets:
            right = self._ticket is not None and hmac.compare_digest(word.encode(), self._ticket.encode())
            if right:
                self._ticket = None
            return right

    def knows(self, connection: socket.socket) -> None:
        """A connection is of the page: it is not hung up on for another one's sake."""
        with self._opening:
            if connection in self._open:
                self._open[connection] = True

    def get_request(self) -> tuple[socket.socket, Any]:
        try:
            return super().get_request()
        except OSError:
            time.sleep(_PAUSE)  # without descriptors the caller would ask again at once, and for ever
            raise

    def process_request(self, request: Any, client_address: Any) -> None:
        """A thread for each connection, of which there are only so many.

        The oldest that has not said the token makes room for a new one; where all have, there is none for it.
        """
        with self._opening:
            strangers = [one for one, known in self._open.items() if not known]
            full = len(self._open) >= _CONNECTIONS
            if not full or strangers:
                self._open[request] = False
            if full and strangers:
                _hang_up(strangers[0])
                del self._open[strangers[0]]
        if full and not strangers:
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except RuntimeError:  # no thread for it
            self._forget(request)
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._forget(request)

    def _forget(self, connection: socket.socket) -> None:
        with self._opening:
            self._open.pop(connection, None)

    def handle_error(self, request: Any, client_address: Any) -> None:
        error = sys.exc_info()[1]
        if isinstance(error, OSError):  # of a page that went away
            return
        spent = error and exhausted(error)
        if spent:
            print(f"clrt: a question was not answered: {spent}", file=sys.stderr)
        else:
            super().handle_error(request, client_address)


def _hang_up(connection: socket.socket) -> None:
    """Wakes whoever reads from it."""
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


class _Handler(BaseHTTPRequestHandler):
    """A connection. Who is not known learns nothing, and is hung up on."""

    server: Server
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "clrt", ""
    timeout = 120  # seconds of silence
    disable_nagle_algorithm = True

    def do_GET(self) -> None:
        word, _, name = self.path.removeprefix("/").partition("/")
        if self._is_at_home() and not name and self.server.take_ticket(word):
            self._send(303, b"", "text/plain", {"Location": f"/{self.server.token}/"})
        elif self._is_allowed(word):
            files = {
                "": (page, "text/html"),
                "view.js": (module, "text/javascript"),
                "view.css": (style, "text/css"),
            }
            if name in files:
                make, kind = files[name]
                self._send(200, make().encode(), f"{kind}; charset=utf-8")
            else:
                self.send_error(404)

    def do_POST(self) -> None:
        word, _, name = self.path.removeprefix("/").partition("/")
        if not self._is_allowed(word):
            return
        body = self._body()
        if body is not None:
            table, data = answered(lambda: self._answer(name, body))
            try:
                whole = packed(table, data)
            except MemoryError:
                whole = packed({"error": NO_MEMORY}, b"")
            self._send(200, whole, "application/octet-stream")

    def _answer(self, name: str, body: bytes) -> Answer:
        try:
            return self.server.session.answer(name, json.loads(body), self._is_gone)
        except (ValueError, RecursionError) as error:
            return {"error": f"the question is no JSON: {error}"}, b""

    # --- who may ask

    def _is_at_home(self) -> bool:
        """Whether the request was sent to this server by itself, as a browser says it."""
        hosts, origins = self.headers.get_all("Host", []), self.headers.get_all("Origin", [])
        return hosts == [self.server.authority] and origins in ([], [self.server.origin])

    def _is_allowed(self, word: str) -> bool:
        """Whether the request is the page's own; if not, it is refused."""
        known = hmac.compare_digest(word.encode(), self.server.token.encode())
        # a browser says the origin of all that a script sends
        said = self.command == "GET" or self.headers.get("Origin") is not None
        allowed = known and said and self._is_at_home()
        if allowed:
            self.server.knows(self.connection)
        else:
            self.send_error(403)
        return allowed

    def _body(self) -> bytes | None:
        """What was sent along; None where it was refused."""
        lengths = self.headers.get_all("Content-Length", [])
        length, wrong = lengths[0] if len(lengths) == 1 else "", 0
        if not (length.isascii() and length.isdecimal()) or "Transfer-Encoding" in self.headers:
            wrong = 411
        elif len(length) > 9 or int(length) > _BODY:
            wrong = 413
        elif self.headers.get_content_type() != "application/json":
            wrong = 415
        if wrong:
            self.send_error(wrong)
            return None
        return self.rfile.read(int(length))

    def _is_gone(self) -> bool:
        """Whether the page has closed the connection on which it waits for an answer."""
        try:
            ready, _, _ = select.select([self.connection], [], [], 0)
            return bool(ready) and not self.connection.recv(1, socket.MSG_PEEK)
        except (OSError, ValueError):
            return True

    # --- what is said

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        self.close_connection = True  # what else it sent stays unread
        text = self.responses.get(code, ("refused", ""))[0]
        self._send(code, f"{code} {text}\n".encode(), "text/plain; charset=utf-8", {"Connection": "close"})

    def _send(self, code: int, body: bytes, kind: str, more: dict[str, str] | None = None) -> None:
        self.send_response(code)
        for name, value in {**_HEADERS, "Content-Type": kind, **(more or {})}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if getattr(self, "command", None) != "HEAD":
            self.wfile.write(body)

    def log_message(self, format: str, *arguments: Any) -> None:
        log.debug("view: %s %s", getattr(self, "command", None) or "?",
                  legible(self.path.rpartition("/")[2]) if getattr(self, "path", None) else "?")  # fmt: skip


def packed(table: dict[str, Any], data: bytes) -> bytes:
    """An answer as bytes: how long the table is as JSON (4 bytes, the lowest first), the table, the data."""
    text = json.dumps(table).encode()
    return len(text).to_bytes(4, "little") + text + data
