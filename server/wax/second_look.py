"""Diagnoses a failed connection by connecting once more; blocks.

OpenSSL says nothing about a certificate that it does not trust, aiohttp and FFmpeg say little about
how a connection ended, and a plain port closes without a word when it gets a TLS handshake.
"""

from __future__ import annotations

import asyncio
import datetime
import socket
import ssl
from functools import partial
from typing import TYPE_CHECKING, Final

from cryptography import x509
from cryptography.x509.oid import ExtensionOID, NameOID

from wax.daemon_call import daemon_call
from wax.unreachable import TlsAnswer, is_certificate, says_enough, why

if TYPE_CHECKING:
    from wax.sentence import Sentence
    from wax.unreachable import Target

LIMIT_S: Final = 2.0
"""The timeout of the connection, and again of each answer; the name lookup has none."""


def explained(target: Target, error: Exception, limit_s: float = LIMIT_S) -> Sentence:
    """Return why a target was not reached; connects once more if the error says too little."""
    now = datetime.datetime.now(datetime.UTC)  # OpenSSL checks certificates by this clock
    if says_enough(error):
        return why(target, error, now, connecting=True)
    try:
        line = socket.create_connection((target.host, target.port), timeout=limit_s)
    except UnicodeError:  # an impossible name
        return why(target, error, now)
    except OSError as found:  # a certificate's error says more than a new failure
        return why(target, error if is_certificate(error) else found, now, connecting=True)
    with line:
        seen = TlsAnswer(speaks_tls=None)
        if target.has_tls or not isinstance(error, TimeoutError):
            hears_out = target.has_tls and not is_certificate(error)
            seen = _try_handshake(line, target.host, hears_out=hears_out)
    return why(target, error, now, seen)


async def explained_aside(target: Target, error: Exception, limit_s: float = LIMIT_S) -> Sentence:
    """Return the same within `limit_s`, from a daemon thread."""
    if says_enough(error):
        return explained(target, error)
    look = partial(explained, target, error, limit_s)
    try:
        async with asyncio.timeout(limit_s):
            return await daemon_call(f"look at {target.host}", look)
    except TimeoutError:
        return why(target, error, datetime.datetime.now(datetime.UTC))


def _try_handshake(line: socket.socket, host: str, *, hears_out: bool) -> TlsAnswer:
    """Try a TLS handshake that verifies nothing and sends no data."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with context.wrap_socket(line, server_hostname=host) as secured:
            shown = secured.getpeercert(binary_form=True)
            refusal = _late_refusal(secured) if hears_out else None
    except TimeoutError:
        return TlsAnswer(speaks_tls=None)
    except ssl.SSLError as error:
        is_alert = "ALERT" in (getattr(error, "reason", None) or "")
        return TlsAnswer(speaks_tls=is_alert, refusal=error if is_alert else None)
    except (OSError, ValueError):  # it hangs up
        return TlsAnswer(speaks_tls=False)
    return _parsed(shown, refusal)


def _late_refusal(secured: ssl.SSLSocket) -> ssl.SSLError | None:
    """Return a refusal that TLS 1.3 sends only after the handshake: it wants our certificate."""
    try:
        secured.recv(1)
    except ssl.SSLError as error:
        return error
    except OSError:  # or TimeoutError: the server waits for data
        return None
    return None


def _parsed(shown: bytes | None, refusal: ssl.SSLError | None) -> TlsAnswer:
    try:
        certificate = x509.load_der_x509_certificate(shown or b"")
        begins, ends = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    except ValueError:
        return TlsAnswer(speaks_tls=True, refusal=refusal)
    return TlsAnswer(True, _names(certificate), begins, ends, refusal)


def _names(certificate: x509.Certificate) -> tuple[str, ...]:
    try:
        found = certificate.extensions.get_extension_for_oid(ExtensionOID.SUBJECT_ALTERNATIVE_NAME)
        value = found.value
        assert isinstance(value, x509.SubjectAlternativeName)
        dns = value.get_values_for_type(x509.DNSName)
        return (*dns, *map(str, value.get_values_for_type(x509.IPAddress)))
    except (x509.ExtensionNotFound, ValueError):
        return tuple(
            str(one.value)
            for one in certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
        )
