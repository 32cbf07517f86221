"""Why another program cannot be reached, and what to do: a sentence for each failure. Pure.

An error alone often says too little: a TLS server that gets plain text closes without a word. Then
a second connection's `TlsAnswer` is needed (`second_look.py`).
"""

from __future__ import annotations

import errno
import http.client
import socket
import ssl
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Self
from urllib.parse import urlsplit

from wax.errors import reason_of
from wax.logs.printable import printable
from wax.sentence import Sentence

if TYPE_CHECKING:
    import datetime

CLOSED: Final = "unreachable.closed"
"""The code if nothing more is known than that the other end closed the connection."""

_MOST_CHARS: Final = 120
_MOST_NAMES: Final = 3
_SECURE: Final = {
    **{plain: f"{plain}s" for plain in ("http", "ws", "mqtt", "rtsp", "rtmp", "turn")},
    "tcp": "tls",
}
_PLAIN: Final = {secure: plain for plain, secure in _SECURE.items()}
_PORTS: Final = {
    "tcp": None,
    "tls": None,
    "http": 80,
    "https": 443,
    "ws": 80,
    "wss": 443,
    "mqtt": 1883,
    "mqtts": 8883,
    "rtsp": 554,
    "rtsps": 322,
    "rtmp": 1935,
    "rtmps": 443,
}

_NO_ROUTE: Final = (errno.EHOSTUNREACH, errno.ENETUNREACH, errno.EADDRNOTAVAIL)
_ENDS: Final = (ConnectionError, EOFError, ssl.SSLEOFError)
_NAME_SERVER_AWAY: Final = (socket.EAI_AGAIN, socket.EAI_FAIL)

# X509_V_ERR_… of OpenSSL (x509_vfy.h); Python has no names for them.
_NOT_YET_VALID: Final = 9
_EXPIRED: Final = 10
_UNKNOWN_AUTHORITY: Final = (2, 18, 19, 20, 21)
_OTHER_NAME: Final = (62, 64)

_NO_TLS: Final = (
    *("WRONG_VERSION_NUMBER", "HTTP_REQUEST", "UNKNOWN_PROTOCOL", "PACKET_LENGTH_TOO_LONG"),
    *("RECORD_LAYER_FAILURE", "BAD_RECORD_TYPE", "UNEXPECTED_MESSAGE"),
)
"""OpenSSL's errors for an answer that is not TLS."""
_OLD_TLS: Final = ("PROTOCOL_VERSION", "UNSUPPORTED_PROTOCOL", "KEY_TOO_SMALL", "MD_TOO_WEAK")


@dataclass(frozen=True, slots=True)
class Target:
    """The program to reach, within `limit_s`.

    `ca_key` is the configuration key for the file of its certificate authority, empty if there is
    no such key; `has_ca` is whether the key is set.
    """

    scheme: str
    host: str
    port: int
    limit_s: float
    ca_key: str = ""
    has_ca: bool = False

    @classmethod
    def of(cls, url: str, limit_s: float, *, ca_key: str = "", has_ca: bool = False) -> Self | None:
        """Return the target of a URL; None for one that is not reached by TCP."""
        try:
            parts = urlsplit(url)
            port = parts.port or _PORTS.get(parts.scheme)
        except ValueError:
            return None
        if parts.scheme not in _PORTS or not parts.hostname or not port:
            return None
        return cls(parts.scheme, parts.hostname, port, limit_s, ca_key, has_ca)

    @property
    def has_tls(self) -> bool:
        """Whether the connection must be encrypted."""
        return self.scheme in _PLAIN

    @property
    def at(self) -> str:
        """Host and port, as in a URL."""
        return f"{f'[{self.host}]' if ':' in self.host else self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class TlsAnswer:
    """What the other end did in a TLS handshake.

    `speaks_tls` is None if it timed out; `names`, `begins` and `ends` are those of its own
    certificate; `refusal` is why it refused our handshake.
    """

    speaks_tls: bool | None
    names: tuple[str, ...] = ()
    begins: datetime.datetime | None = None
    ends: datetime.datetime | None = None
    refusal: ssl.SSLError | None = None


def is_certificate(error: Exception) -> bool:
    """Whether the certificate failed verification; the error does not say what is in it."""
    return isinstance(_root(error), ssl.SSLCertVerificationError)


def says_enough(error: Exception) -> bool:
    """Whether the reason is known without a second connection."""
    error = _root(error)
    if isinstance(error, ssl.SSLError):
        known = _refused(error, "") is not None
        return known and not isinstance(error, ssl.SSLCertVerificationError)
    if isinstance(error, socket.gaierror | ValueError) or _is_no_http(error):
        return True
    return isinstance(error, OSError) and error.errno in (
        *(errno.ECONNREFUSED, errno.EACCES, errno.EPERM, errno.EINVAL),
        *_NO_ROUTE,
    )


def why(
    target: Target,
    error: Exception,
    now: datetime.datetime,
    seen: TlsAnswer | None = None,
    *,
    connecting: bool = False,
) -> Sentence:
    """Return why a target was not reached; `now` is this machine's time, with a time zone.

    `connecting` is whether it failed before there was a connection.
    """
    error = _root(error)
    if isinstance(error, ssl.SSLCertVerificationError):
        return _certificate(target, error, now, seen)
    told = _by_handshake(target, seen)
    if told is None and isinstance(error, ssl.SSLError):
        told = _refused(error, target.at, _PLAIN.get(target.scheme, ""))
    if told is None and isinstance(error, socket.gaierror):
        away = error.errno in _NAME_SERVER_AWAY
        told = Sentence(
            "unreachable.no_name_server" if away else "unreachable.no_name", {"host": target.host}
        )
    return told or _by_socket(target, error, seen, connecting=connecting)


def _by_handshake(target: Target, seen: TlsAnswer | None) -> Sentence | None:
    if seen is None or seen.speaks_tls is None:
        return None
    if seen.speaks_tls and not target.has_tls:
        better = _SECURE[target.scheme]
        return Sentence("unreachable.tls", {"at": target.at, "scheme": f"{better}://"})
    if not target.has_tls:
        return None
    plain = _PLAIN[target.scheme]
    if not seen.speaks_tls:
        return Sentence("unreachable.no_tls", {"at": target.at, "scheme": f"{plain}://"})
    return None if seen.refusal is None else _refused(seen.refusal, target.at, plain)


def _by_socket(
    target: Target, error: Exception, seen: TlsAnswer | None, *, connecting: bool
) -> Sentence:
    number = error.errno if isinstance(error, OSError) else None
    if isinstance(error, TimeoutError):
        return _too_late(target, seen, connecting=connecting)
    if number == errno.ECONNREFUSED:
        told = Sentence("unreachable.nobody", {"at": target.at})
    elif number in _NO_ROUTE:
        told = Sentence("unreachable.no_route", {"host": target.host})
    elif _is_no_http(error):  # its message quotes the URL, and a stranger's text
        told = Sentence("unreachable.no_http", {"at": target.at})
    elif isinstance(error, ValueError):  # its message may quote the URL, too
        told = Sentence("unreachable.not_possible")
    elif isinstance(error, _ENDS) or not isinstance(error, OSError):  # or aiohttp's own
        told = Sentence("unreachable.closed", {"at": target.at})
    else:
        told = Sentence("unreachable.failed", {"why": printable(reason_of(error), _MOST_CHARS)})
    return told


def _too_late(target: Target, seen: TlsAnswer | None, *, connecting: bool) -> Sentence:
    if connecting:
        return Sentence("unreachable.no_connection", {"at": target.at, "limit": target.limit_s})
    if seen is None:
        return Sentence("unreachable.silent", {"limit": target.limit_s})
    return Sentence("unreachable.hangs", {"at": target.at, "limit": target.limit_s})


def _is_no_http(error: Exception) -> bool:
    """Whether an answer was not HTTP; only then does aiohttp's error have a `status`."""
    if isinstance(error, OSError):
        return False
    return isinstance(error, http.client.HTTPException) or hasattr(error, "status")


def _refused(error: ssl.SSLError, at: str, plain: str = "") -> Sentence | None:
    """Return what a failed handshake means; None if it may mean anything."""
    reason = getattr(error, "reason", None) or ""
    if "CERTIFICATE_REQUIRED" in reason:
        return Sentence("unreachable.wants_certificate")
    if any(one in reason for one in _NO_TLS):
        return Sentence("unreachable.no_tls", {"at": at, "scheme": f"{plain}://"})
    if any(one in reason for one in _OLD_TLS):
        return Sentence("unreachable.old_tls")
    if "HANDSHAKE_FAILURE" in reason:
        return Sentence("unreachable.handshake")
    return None


def _certificate(
    target: Target,
    error: ssl.SSLCertVerificationError,
    now: datetime.datetime,
    seen: TlsAnswer | None,
) -> Sentence:
    code = error.verify_code
    if code in _OTHER_NAME:
        return _other_name(target, seen)
    if code in (_EXPIRED, _NOT_YET_VALID):
        return _out_of_time(now, seen, is_over=code == _EXPIRED)
    if code not in _UNKNOWN_AUTHORITY:
        return Sentence(
            "unreachable.untrusted", {"why": printable(error.verify_message, _MOST_CHARS)}
        )
    if not target.ca_key:
        return Sentence("unreachable.authority")
    return Sentence(
        "unreachable.other_authority" if target.has_ca else "unreachable.own_authority",
        {"key": target.ca_key},
    )


def _other_name(target: Target, seen: TlsAnswer | None) -> Sentence:
    if seen is None or not seen.names:
        return Sentence("unreachable.other_name_only", {"host": target.host})
    names = printable(", ".join(seen.names[:_MOST_NAMES]), _MOST_CHARS)
    return Sentence("unreachable.other_name", {"host": target.host, "names": names})


def _out_of_time(now: datetime.datetime, seen: TlsAnswer | None, *, is_over: bool) -> Sentence:
    """Say when the certificate was or will be valid, or that one above it is out of date."""
    ends, begins = (None, None) if seen is None else (seen.ends, seen.begins)
    clock = f"{now:%Y-%m-%d %H:%M} UTC"
    if is_over:
        if ends is None or ends > now:
            return Sentence("unreachable.authority_expired", {"now": clock})
        return Sentence("unreachable.expired", {"ends": f"{ends:%Y-%m-%d}", "now": clock})
    if begins is None or begins < now:
        return Sentence("unreachable.authority_not_yet", {"now": clock})
    return Sentence("unreachable.not_yet", {"begins": f"{begins:%Y-%m-%d}", "now": clock})


def _root(error: Exception) -> Exception:
    """Return the cause inside aiohttp's and urllib's errors."""
    for name in ("certificate_error", "os_error", "reason"):
        inside = getattr(error, name, None)
        if isinstance(inside, Exception):
            return _root(inside)
    return error
