"""`clrt view` as a process: its address, its end, and what it cannot show."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import pytest

import clrt
from clrt.cli import main
from clrt.view import browser
from tests.cli.test_terminal import fault
from tests.view_samples import SCENE

CLRT = [sys.executable, "-m", "clrt"]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    clrt.load_dict(SCENE).save(tmp_path / "ball.json")
    return tmp_path / "ball.json"


def begun(*words: object, **environment: str) -> tuple[subprocess.Popen[str], str]:
    command, pipe, around = [*CLRT, "view", *map(str, words)], subprocess.PIPE, {**os.environ, **environment}
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=around)
    assert process.stdout
    return process, process.stdout.readline().strip()


def test_it_serves_until_ctrl_c(file: Path) -> None:
    """At an address that is printed first; then one line says that it has ended."""
    process, address = begun(file, "--no-browser")
    try:
        assert address.startswith("http://127.0.0.1:") and len(address.split("/")[3]) >= 32
        with urllib.request.urlopen(address, timeout=60) as page:
            assert b"view.js" in page.read()
    finally:
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130 and out == ""
    assert err.splitlines() == [
        "clrt: open this address in a browser on this machine; Ctrl-C ends it",
        "clrt: interrupted; the page has ended",
    ]


def test_a_browser_is_opened_at_an_address_that_is_good_once(file: Path, tmp_path: Path) -> None:
    """What stands on a browser's command line, which all can read, is not the page's own address."""
    script = tmp_path / "browser"
    script.write_text(
        f'#!/bin/sh\necho "$1" > {tmp_path}/opened.part; mv {tmp_path}/opened.part {tmp_path}/opened\n'
    )
    script.chmod(0o755)
    process, address = begun(file, BROWSER=f"{script} %s")
    try:
        while not (tmp_path / "opened").exists():
            assert process.poll() is None
        opened = (tmp_path / "opened").read_text().strip()
        assert opened != address and opened.startswith(address.rsplit("/", 2)[0])
        with urllib.request.urlopen(opened, timeout=60) as page:
            assert page.url == address
    finally:
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert "your browser shows it" in err


def test_no_browser_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert not browser.opens("http://127.0.0.1:1/")

    def none(*_: object) -> object:
        raise browser.webbrowser.Error

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(browser.webbrowser, "get", none)
    assert not browser.opens("http://127.0.0.1:1/")


@pytest.mark.parametrize("wrong", ["foo '%s", "/bin/false %s", "/no/such %s", "no-such-browser"])
def test_a_browser_that_cannot_be_started_is_none(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BROWSER", wrong)
    assert not browser.opens("http://127.0.0.1:1/")


def test_a_browser_that_fails_is_none_and_one_that_goes_on_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BROWSER", "any")
    for reason in (browser.webbrowser.Error("x"), ValueError("x"), OSError("x")):

        def fails(address: str, reason: Exception = reason) -> bool:
            raise reason

        monkeypatch.setattr(browser.webbrowser, "get", lambda fails=fails: SimpleNamespace(open=fails))
        assert not browser.opens("http://127.0.0.1:1/")
    closed = threading.Event()
    waiting = SimpleNamespace(open=lambda address: closed.wait(60))
    monkeypatch.setattr(browser.webbrowser, "get", lambda: waiting)
    assert browser.opens("http://127.0.0.1:1/")
    closed.set()


def test_no_browser_leaves_the_address(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("clrt.view.browser.opens", lambda address: False)
    monkeypatch.setattr("clrt.view.server.Server.serve_forever", lambda self: None)
    assert main(["view", str(file)]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("http://127.0.0.1:")
    assert (
        said.err == "clrt: no browser was found: open this address in one on this machine; Ctrl-C ends it\n"
    )


def test_what_cannot_be_shown_is_said(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blind = tmp_path / "blind.json"
    clrt.load_dict({name: value for name, value in SCENE.items() if name != "camera"}).save(blind)
    assert "blind.json: camera: missing; to look at the scene it needs a [camera]" in fault(
        capsys, "view", blind
    )
    assert "--port: 65536 is not allowed; it must be from 0" in fault(capsys, "view", file, "--port", "65536")
    assert "--port: -1 is not allowed" in fault(capsys, "view", file, "--port", "-1")
    assert "neither a file nor a scene" in fault(capsys, "view", "nothing")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert f"--port {port}: is in use" in fault(capsys, "view", file, "--port", port)
