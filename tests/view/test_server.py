"""The viewer's server: whom it answers."""

from __future__ import annotations

import errno
import socket
import time
from contextlib import suppress
from typing import Any

import pytest

import clrt
from clrt.view import server as servers
from clrt.view.server import Server
from clrt.view.session import Session
from tests.view_samples import ask, request, serving, unpacked


def test_the_page_asks_nobody_else(server: Server) -> None:
    for name, kind in (("", "text/html"), ("view.js", "text/javascript"), ("view.css", "text/css")):
        status, headers, body = request(server, "GET", f"/{server.token}/{name}", Origin=None)
        assert status == 200 and headers["Content-Type"].startswith(kind) and body
        policy = headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy and "unsafe" not in policy and "http" not in policy
        assert headers["Referrer-Policy"] == "no-referrer" and headers["Cache-Control"] == "no-store"
        assert server.token.encode() not in body and b"://" not in body
        assert not any(
            word in body for word in (b"innerHTML", b"insertAdjacentHTML", b"eval(", b"document.write")
        )
    assert request(server, "GET", f"/{server.token}/server.py", Origin=None)[0] == 404


@pytest.mark.parametrize("method", ["GET", "POST"])
@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/", {}),
        ("/view.js", {}),
        ("/wrong/", {}),
        ("/{token}x/", {}),
        ("/../{token}/", {}),
        ("/é/", {}),
        ("http://evil.example/{token}/", {}),
        ("/{token}/", {"Host": "localhost:{port}"}),
        ("/{token}/", {"Host": "evil.example:{port}"}),
        ("/{token}/", {"Host": "127.0.0.1"}),
        ("/{token}/", {"Host": "127.0.0.1:1"}),
        ("/{token}/", {"Host": "127.0.0.1:{port}\n127.0.0.1:{port}"}),
        ("/{token}/", {"Host": None}),
        ("/{token}/", {"Origin": "http://evil.example"}),
        ("/{token}/", {"Origin": "http://localhost:{port}"}),
        ("/{token}/", {"Origin": "https://127.0.0.1:{port}"}),
        ("/{token}/", {"Origin": "http://127.0.0.1"}),
        ("/{token}/", {"Origin": "null"}),
    ],
)
def test_others_are_refused(server: Server, method: str, path: str, headers: dict[str, str | None]) -> None:
    words = {"token": server.token, "port": server.server_port}
    given = {name: value and value.format(**words) for name, value in headers.items()}
    path = path.format(**words).encode().decode("latin-1")
    for name in ("", "open") if method == "POST" else ("",):
        body = b"{}" if method == "POST" else None
        connection = socket.create_connection(("127.0.0.1", server.server_port))
        sent = {
            "Host": server.authority,
            "Origin": server.origin,
            "Content-Type": "application/json",
            "Connection": "close",  # else what is not refused would be waited for
            **given,
        }
        lines = [f"{method} {path}{name} HTTP/1.1"]
        lines += [
            f"{key}: {one}" for key, value in sent.items() if value is not None for one in value.split("\n")
        ]
        lines += [f"Content-Length: {len(body)}"] if body else []
        with connection:
            connection.sendall("\r\n".join([*lines, "", ""]).encode("latin-1") + (body or b""))
            answer = connection.makefile("rb").read()
        assert answer.startswith(b"HTTP/1.1 403 "), answer
        assert b"Content-Security-Policy" in answer and server.token.encode() not in answer


def test_a_question_without_an_origin_is_refused(server: Server) -> None:
    assert request(server, "POST", f"/{server.token}/open", b"{}", Origin=None)[0] == 403


@pytest.mark.parametrize("method", ["PUT", "OPTIONS", "DELETE", "HEAD", "TRACE"])
def test_other_methods_are_unknown(server: Server, method: str) -> None:
    assert request(server, method, f"/{server.token}/")[0] == 501


def test_the_ticket_leads_to_the_page_once(session: Session) -> None:
    with serving(session) as server:
        path = server.ticket.removeprefix(server.origin)
        assert request(server, "GET", path, Origin=None, Host="evil.example")[0] == 403
        status, headers, _ = request(server, "GET", path, Origin=None)
        assert (status, headers["Location"]) == (303, f"/{server.token}/")
        assert request(server, "GET", path, Origin=None)[0] == 403
        assert server.token not in path and server.ticket == f"{server.origin}/None/"
        assert request(server, "GET", "/None/", Origin=None)[0] == 403


def test_bodies_are_small_json(server: Server) -> None:
    path = f"/{server.token}/open"
    assert request(server, "POST", path)[0] == 411
    assert request(server, "POST", path, b"{}", Content_Length="-2")[0] == 411
    assert request(server, "POST", path, b"2\r\n{}\r\n0\r\n\r\n", Transfer_Encoding="chunked")[0] == 411
    for length in ("1048577", "9" * 30):
        assert request(server, "POST", path, b"", Content_Length=length)[0] == 413
    assert request(server, "POST", path, b"{}", Content_Type="text/plain")[0] == 415
    for body in (b"{", b"\xff", b"[" * 100_000):
        status, _, data = request(server, "POST", path, body)
        assert status == 200 and "no JSON" in unpacked(data)[0]["error"]
    for body in (b"[]", b"5", b"null"):
        assert "not allowed" in unpacked(request(server, "POST", path, body)[2])[0]["error"]
    assert "is no question" in ask(server, "nothing")[0]["error"]


def test_a_port_in_use_is_said(session: Session, server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(clrt.ClrtError, match=f"--port {server.server_port}: is in use; name another one"):
        Server(session, server.server_port)

    def forbidden(self: Any) -> None:
        raise OSError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Server, "server_bind", forbidden)
    with pytest.raises(clrt.ClrtError, match=r"--port 80: cannot be had \(Permission denied\)"):
        Server(session, 80)


def _held(server: Server, say: bytes) -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", server.server_port), timeout=10)
    connection.sendall(say)
    if say:
        assert connection.recv(12) == b"HTTP/1.1 200"
    return connection


def test_connections_that_say_nothing_make_room_for_the_page(server: Server) -> None:
    held = [_held(server, b"") for _ in range(100)]
    assert request(server, "GET", f"/{server.token}/", Origin=None)[0] == 200
    assert not held[0].recv(1), "the oldest is hung up on"
    for connection in held:
        connection.close()


def test_connections_of_the_page_are_not_hung_up_on(session: Session) -> None:
    with serving(session) as server:
        say = f"GET /{server.token}/ HTTP/1.1\r\nHost: {server.authority}\r\n\r\n".encode()
        held = [_held(server, say) for _ in range(32)]
        more = socket.create_connection(("127.0.0.1", server.server_port), timeout=10)
        assert not more.recv(1), "there is no room for another one"
        held[0].close()
        held[1].sendall(say)
        assert held[1].recv(1)
        for _ in range(100):  # the first one's thread ends soon
            with suppress(ConnectionError):
                if request(server, "GET", f"/{server.token}/", Origin=None)[0] == 200:
                    break
            time.sleep(0.05)
        else:
            pytest.fail("the place of one that went is not given to another")
        for connection in held:
            connection.close()


def test_want_of_threads_and_descriptors_is_waited_out(
    session: Session, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with serving(session) as server:
        asked: list[float] = []

        def no_descriptor() -> None:
            asked.append(time.monotonic())
            raise OSError(errno.EMFILE, "Too many open files")

        def no_thread(*_: object) -> None:
            raise RuntimeError("can't start new thread")

        with monkeypatch.context() as patch:
            patch.setattr("socketserver.ThreadingMixIn.process_request", no_thread)
            connection = socket.create_connection(("127.0.0.1", server.server_port), timeout=10)
            assert not connection.recv(1)
        with monkeypatch.context() as patch:
            patch.setattr("socketserver.TCPServer.get_request", lambda _: no_descriptor())
            connection = socket.create_connection(("127.0.0.1", server.server_port), timeout=10)
            time.sleep(0.5)
        assert 1 <= len(asked) <= 10, "it asked again and again"
        assert request(server, "GET", f"/{server.token}/", Origin=None)[0] == 200
    assert capsys.readouterr().err == ""


def test_two_lengths_of_a_body_are_refused(server: Server) -> None:
    lines = [
        f"POST /{server.token}/open HTTP/1.1", f"Host: {server.authority}", f"Origin: {server.origin}",
        "Content-Type: application/json", "Connection: close", "Content-Length: 2", "Content-Length: 20",
        "", "{}",
    ]  # fmt: skip
    with socket.create_connection(("127.0.0.1", server.server_port)) as connection:
        connection.sendall("\r\n".join(lines).encode())
        assert connection.makefile("rb").read().startswith(b"HTTP/1.1 411 ")


SPENT = [(MemoryError(), "no memory left"), (RuntimeError("can't start new thread"), "no more processes")]


@pytest.mark.parametrize(("error", "said"), SPENT)
def test_what_runs_out_for_an_answer_is_said(
    error: Exception, said: str, session: Session, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    def spent(*_: object) -> None:
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(session, "answer", spent)
        assert said in ask(server, "open")[0]["error"]
    assert "error" not in ask(server, "open")[0]


def test_an_answer_that_does_not_fit_into_memory_is_said(
    server: Server, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """It is copied once more to be sent. What has no answer is one line."""
    whole = servers.packed

    def spent(table: dict[str, Any], data: bytes) -> bytes:
        if "error" in table:
            return whole(table, data)
        raise MemoryError

    monkeypatch.setattr(servers, "packed", spent)
    assert "no memory left" in ask(server, "open")[0]["error"]
    assert capfd.readouterr().err == ""
    monkeypatch.setattr(servers, "page", lambda: spent({}, b""))
    with pytest.raises(ConnectionError):
        request(server, "GET", f"/{server.token}/", Origin=None)
    assert capfd.readouterr().err.startswith("clrt: a question was not answered: this machine has no memory")
