"""What each failure to reach another program means, and what to do."""

from __future__ import annotations

import datetime
import errno
import re
import socket
import ssl
import urllib.error
from dataclasses import replace

import pytest

from wax.unreachable import Target, TlsAnswer, why

NOW = datetime.datetime(2026, 3, 1, 12, tzinfo=datetime.UTC)
DAY = datetime.timedelta(days=1)
PLAIN = Target("http", "home", 80, 3.0)
TLS = Target("mqtts", "home", 8883, 3.0, ca_key="[mqtt] ca_file")
SHOWN = TlsAnswer(
    speaks_tls=True, names=("a.example", "b.example"), begins=NOW - DAY, ends=NOW + DAY
)


def tls_error(reason: str) -> ssl.SSLError:
    error = ssl.SSLError(1, f"[SSL: {reason}] words")
    error.reason = reason
    return error


def untrusted(code: int) -> ssl.SSLCertVerificationError:
    error = ssl.SSLCertVerificationError(1, "words")
    error.verify_code, error.verify_message = code, "OpenSSL's words"
    return error


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (ConnectionRefusedError(errno.ECONNREFUSED, "Connect call failed ('::1', 9)"), "nobody"),
        (OSError(errno.EHOSTUNREACH, "No route to host"), "no_route"),
        (OSError(errno.ENETUNREACH, "Network is unreachable"), "no_route"),
        (socket.gaierror(socket.EAI_NONAME, "Name or service not known"), "no_name"),
        (socket.gaierror(socket.EAI_AGAIN, "Temporary failure"), "no_name_server"),
        (TimeoutError(), "silent"),
        (ConnectionResetError(errno.ECONNRESET, "Connection reset by peer"), "closed"),
        (ssl.SSLEOFError(8, "EOF occurred in violation of protocol"), "closed"),
        (EOFError(), "closed"),
        (ValueError("http://home/secret"), "not_possible"),
        (OSError(errno.EACCES, "that is this server itself"), "failed"),
        (urllib.error.URLError(ConnectionRefusedError(errno.ECONNREFUSED, "no")), "nobody"),
    ],
)
def test_each_failure_of_a_socket_has_its_sentence(error: Exception, kind: str) -> None:
    """Each socket error, wrapped or not, has its sentence, with all values and without the path."""
    told = why(PLAIN, error, NOW)
    assert told.code == f"unreachable.{kind}"
    assert "…" not in str(told)
    assert "secret" not in str(told)


def test_no_connection_is_not_a_silent_program() -> None:
    """A connection that times out is told apart from a program that does not answer."""
    connecting = why(PLAIN, TimeoutError(), NOW, connecting=True)
    assert str(connecting).startswith("No connection to home:80 is made within 3 s")
    assert str(why(PLAIN, TimeoutError(), NOW, TlsAnswer(None))).startswith(
        "home:80 accepts the conn"
    )


@pytest.mark.parametrize(
    ("reason", "kind"),
    [
        ("WRONG_VERSION_NUMBER", "no_tls"),
        ("TLSV13_ALERT_CERTIFICATE_REQUIRED", "wants_certificate"),
        ("SSLV3_ALERT_HANDSHAKE_FAILURE", "handshake"),
        ("TLSV1_ALERT_PROTOCOL_VERSION", "old_tls"),
        ("UNSUPPORTED_PROTOCOL", "old_tls"),
        ("TLSV1_ALERT_INTERNAL_ERROR", "failed"),
    ],
)
def test_each_failure_of_a_handshake_has_its_sentence(reason: str, kind: str) -> None:
    """Each handshake error has its sentence, also if only the second connection meets it."""
    error = tls_error(reason)
    assert why(TLS, error, NOW).code == f"unreachable.{kind}"
    if kind not in ("failed", "no_tls"):
        seen = TlsAnswer(speaks_tls=True, refusal=error)
        assert why(TLS, ConnectionResetError(), NOW, seen).code == f"unreachable.{kind}"


def test_the_wrong_one_of_two_ports_is_said() -> None:
    """TLS to a plain port, and the reverse, are recognized, with the scheme to write."""
    told = why(TLS, ConnectionResetError(), NOW, TlsAnswer(speaks_tls=False))
    assert told.code == "unreachable.no_tls"
    assert "write mqtt:// in" in str(told)
    told = why(PLAIN, ConnectionResetError(), NOW, SHOWN)
    assert told.code == "unreachable.tls"
    assert "write https:// in" in str(told)
    assert why(PLAIN, ConnectionResetError(), NOW, TlsAnswer(speaks_tls=False)).code.endswith(
        "closed"
    )


@pytest.mark.parametrize(
    ("code", "seen", "says"),
    [
        (62, SHOWN, "is for a.example, b.example, not for home"),
        (62, None, "is for another name than home"),
        (64, SHOWN, "is for a.example, b.example, not for home"),
        (10, replace(SHOWN, ends=NOW - DAY), r"expired on 2026-02-28.* says 2026-03-01 12:00 UTC"),
        (10, SHOWN, "of its authority has expired"),
        (9, replace(SHOWN, begins=NOW + DAY), r"from 2026-03-02 on, .*clock says 2026-03-01 12:00"),
        (9, SHOWN, "of its authority is not yet valid.*clock"),
        (18, SHOWN, r"name the file of its authority in \[mqtt\] ca_file"),
        (19, None, r"name the file of its authority in \[mqtt\] ca_file"),
        (20, None, r"name the file of its authority in \[mqtt\] ca_file"),
        (23, None, "not trusted: OpenSSL's words"),
    ],
)
def test_each_fault_of_a_certificate_has_its_advice(
    code: int, seen: TlsAnswer | None, says: str
) -> None:
    """Each certificate error has its advice; `ca_file` is named only for an unknown authority."""
    assert re.search(says, str(why(TLS, untrusted(code), NOW, seen)))


def test_an_authority_is_named_where_it_can_be() -> None:
    """The advice names the configuration key for an authority, and whether it holds a wrong one."""
    told = str(why(replace(TLS, has_ca=True), untrusted(20), NOW))
    assert told.startswith("Its certificate is not by the authority in [mqtt] ca_file")
    assert why(PLAIN, untrusted(20), NOW).code == "unreachable.authority"


@pytest.mark.parametrize(
    ("url", "at"),
    [
        ("mqtts://home", "home:8883"),
        ("http://[fd00::1]/x", "[fd00::1]:80"),
        ("rtsp://user:pw@camera:8554/x", "camera:8554"),
        ("udp://camera:5000", None),
        ("rtsp:///x", None),
        ("http://home:x/", None),
    ],
)
def test_a_target_is_read_from_its_address(url: str, at: str | None) -> None:
    """A target is a URL's host and port, without its secrets; None if it does not use TCP."""
    target = Target.of(url, 1.0)
    assert (None if target is None else target.at) == at
