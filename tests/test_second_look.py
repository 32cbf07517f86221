"""The diagnosis of failed connections, with programs that really fail so."""

from __future__ import annotations

import socket
import ssl
import threading
from typing import TYPE_CHECKING

import pytest
from tests.tls_server import DAY, NOW, pair, server_context, serving

from wax.second_look import explained, explained_aside
from wax.unreachable import Target

if TYPE_CHECKING:
    from pathlib import Path

    from wax.sentence import Sentence


def _told(port: int, scheme: str, authority: Path | None = None, limit_s: float = 2.0) -> Sentence:
    """Return the diagnosis of a failed connection to this port."""
    target = Target.of(f"{scheme}://localhost:{port}", limit_s)
    assert target is not None
    context = ssl.create_default_context(cafile=authority)
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=limit_s) as line:
            asks = (
                context.wrap_socket(line, server_hostname="localhost")
                if scheme[-1] == "s"
                else line
            )
            with asks:
                asks.sendall(b"GET / HTTP/1.0\r\n\r\n")
                while asks.recv(1000):
                    pass
        raise EOFError
    except (OSError, EOFError) as error:
        return explained(target, error, limit_s)


def test_a_certificates_own_words_are_told(tmp_path: Path) -> None:
    """The sentence has the certificate's names and dates, which OpenSSL's error lacks."""
    other = pair(tmp_path, "other.example")
    with serving(server_context(other)) as port:
        assert "is for other.example, not for localhost" in str(_told(port, "https", other))
        assert _told(port, "https").code == "unreachable.authority"
    old = pair(tmp_path, begins=NOW - 9 * DAY, ends=NOW - 2 * DAY)
    with serving(server_context(old)) as port:
        assert f"expired on {NOW - 2 * DAY:%Y-%m-%d}" in str(_told(port, "https", old))
    early = pair(tmp_path, begins=NOW + 2 * DAY)
    with serving(server_context(early)) as port:
        assert f"valid from {NOW + 2 * DAY:%Y-%m-%d} on" in str(_told(port, "https", early))


def test_who_expects_tls_is_noticed(tmp_path: Path) -> None:
    """A TLS server that only hangs up on plain text is recognized."""
    with serving(server_context(pair(tmp_path))) as port:
        assert _told(port, "http").code == "unreachable.tls"


@pytest.mark.parametrize("answer", [b"", b"SSH-2.0-x\r\n", b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_who_speaks_no_tls_is_noticed(answer: bytes) -> None:
    """A plain server is recognized whether it hangs up on a handshake or answers it."""
    with serving(None, answer) as port:
        assert _told(port, "https").code == "unreachable.no_tls"
        assert _told(port, "http").code == "unreachable.closed"


@pytest.mark.parametrize(
    ("newest", "kind"),
    [(ssl.TLSVersion.TLSv1_3, "wants_certificate"), (ssl.TLSVersion.TLSv1_2, "handshake")],
)
def test_who_wants_a_clients_certificate_is_noticed(
    tmp_path: Path, newest: ssl.TLSVersion, kind: str
) -> None:
    """A server that wants a client certificate is recognized, by TLS 1.3 after the handshake."""
    own = pair(tmp_path)
    context = server_context(own, wants_client=True)
    context.maximum_version = newest
    with serving(context) as port:
        assert _told(port, "https", own).code == f"unreachable.{kind}"
        target = Target("https", "localhost", port, 2.0)
        assert explained(target, ConnectionResetError()).code == f"unreachable.{kind}"


def test_one_that_accepts_and_is_silent_is_no_firewall() -> None:
    """A server that accepts and stays silent is told apart from a firewall, without a handshake."""
    with socket.create_server(("127.0.0.1", 0)) as silent:
        assert _told(silent.getsockname()[1], "http", limit_s=0.05).code == "unreachable.hangs"


def test_the_second_look_says_what_the_first_error_does_not() -> None:
    """A missing name or a closed port is recognized behind FFmpeg's error, which says nothing."""
    nobody = Target("http", "localhost", 9, 1.0)
    assert explained(nobody, ConnectionAbortedError()).code == "unreachable.nobody"
    nameless = Target("http", "nowhere.invalid", 80, 1.0)
    code = explained(nameless, ConnectionAbortedError()).code
    assert code in ("unreachable.no_name", "unreachable.no_name_server")


async def test_a_look_that_takes_too_long_is_given_up() -> None:
    """A diagnosis that times out falls back on the first error, and uses no executor thread."""
    with socket.create_server(("127.0.0.1", 0)) as silent:
        target = Target("https", "localhost", silent.getsockname()[1], 3.0)
        told = await explained_aside(target, ConnectionResetError(), 0.05)
        for one in threading.enumerate():
            if one.name.startswith("look "):
                one.join(5)
    assert told.code == "unreachable.closed"
