"""The check whether the page opens at its public address."""

from __future__ import annotations

import email.utils
import socket
import ssl
import threading
from contextlib import contextmanager
from datetime import timedelta
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import TYPE_CHECKING

import pytest
from tests.commands.doctor.certificates import NOW, write_pair

from wax.door.page import CLOCK_OFF_S, check_page

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = pytest.mark.system

NOW_S = 1_800_000_000.0


class Door(HTTPServer):
    """Answers as the door's Caddy does, with a page that opens or not."""

    status = 200
    reason: str | None = None
    date = email.utils.formatdate(NOW_S, usegmt=True)

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Answer)
        self.scheme = "http"

    @property
    def url(self) -> str:
        return f"{self.scheme}://127.0.0.1:{self.server_port}"


class _Answer(BaseHTTPRequestHandler):
    def do_GET(self) -> None:  # http.server's form
        assert isinstance(self.server, Door)
        is_page = self.path == "/healthz"
        if not is_page:
            self.send_response_only(426)
        else:
            self.send_response_only(self.server.status, self.server.reason)
            self.send_header("Location", f"{self.server.url}/elsewhere")
        # The page itself answers with the robot's date.
        date = email.utils.formatdate(0, usegmt=True) if is_page else self.server.date
        self.send_header("Date", date)
        body = str(id(self.server)).encode()
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None: ...


@contextmanager
def served() -> Iterator[Door]:
    with Door() as made:
        thread = threading.Thread(target=made.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield made
        made.shutdown()
        thread.join()


@pytest.fixture
def door() -> Iterator[Door]:
    with served() as made:
        yield made


def code(door: Door, *, ahead_s: float = 0.0) -> str | None:
    found = check_page(door.url, NOW_S + ahead_s, None)
    return None if found is None else found.code


def test_a_page_that_opens_is_well(door: Door) -> None:
    """A page that opens has no problem; a 502 is one."""
    assert code(door) is None
    door.status = 502
    assert code(door) == "tunnel.page"


def test_a_page_that_leads_elsewhere_is_not_followed(door: Door) -> None:
    """A redirect is a problem and is not followed: it could lead into the robot's network."""
    door.status = 302
    found = check_page(door.url, NOW_S, None)
    assert found is not None
    assert "302" in str(found)


@pytest.mark.parametrize(
    "date", ["Mon, 01 Jan 99999999999 00:00:00 GMT", "Mon, 01 Jan 2020 00:00:00 +9" + "9" * 20, "?"]
)
def test_what_answers_there_may_say_anything(door: Door, date: str) -> None:
    """An invalid date is ignored, and the quoted reason is short and printable."""
    door.date, door.status, door.reason = date, 502, "\x1b[2J" + "x" * 5000
    found = check_page(door.url, NOW_S, None)
    assert found is not None
    assert found.code == "tunnel.page"
    assert len(str(found)) < 300
    assert str(found).isprintable()


@pytest.mark.parametrize("ahead_s", [-86_400.0, 86_400.0])
def test_a_clock_that_is_wrong_by_a_day_is_the_first_to_be_told(door: Door, ahead_s: float) -> None:
    """A wrong clock is reported first: it makes everything else fail, certificates above all."""
    door.status = 502
    assert code(door, ahead_s=ahead_s) == "tunnel.clock"
    door.status = 200
    assert code(door, ahead_s=ahead_s) == "tunnel.clock"
    assert code(door, ahead_s=CLOCK_OFF_S - 1) is None


def test_a_page_of_another_server_is_told(door: Door) -> None:
    """An answer by another server is reported: its name or its door's line is not ours alone."""
    assert check_page(door.url, NOW_S, f"127.0.0.1:{door.server_port}") is None
    with served() as mine:
        found = check_page(door.url, NOW_S, f"127.0.0.1:{mine.server_port}")
    assert found is not None
    assert found.code == "tunnel.another"


@pytest.mark.parametrize(
    ("trusted", "why"), [(False, "not by an authority"), (True, "certificate expired on")]
)
def test_a_certificate_that_does_not_count_is_told(
    door: Door, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, why: str, *, trusted: bool
) -> None:
    """A certificate that is untrusted or expired is reported with the reason."""
    long_ago = NOW - timedelta(days=3000)
    pair = write_pair(tmp_path, "127.0.0.1", begins=long_ago, ends=long_ago + timedelta(days=90))
    if trusted:
        monkeypatch.setenv("SSL_CERT_FILE", str(pair.chain))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(pair.chain, pair.key)
    door.socket = context.wrap_socket(door.socket, server_side=True)
    door.scheme = "https"
    found = check_page(door.url, NOW_S, None)
    assert found is not None
    assert (found.code, why in str(found)) == ("tunnel.certificate", True)


def test_a_page_that_nobody_serves_is_told() -> None:
    """A refused connection is reported as such."""
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))
        found = check_page(f"http://127.0.0.1:{nobody.getsockname()[1]}", NOW_S, None)
    assert found is not None
    assert found.code == "tunnel.not_reached"
