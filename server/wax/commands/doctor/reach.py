"""`wax doctor --reach URL`: connects from another machine as a viewer's browser does."""

from __future__ import annotations

import asyncio
import datetime
import hashlib
import socket
import ssl
import time
import urllib.error
import urllib.request
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from pydantic_core import from_json

from wax.client import Client
from wax.commands.doctor.verdict import Verdict, bad, ok, warning
from wax.errors import ConfigError, SignallingError
from wax.second_look import explained
from wax.unreachable import Target

if TYPE_CHECKING:
    from wax.sentence import Sentence

_ANSWER_S: Final = 5.0
_PICTURE_S: Final = 5.0
LIMIT_S: Final = 30.0
"""The limit of each check; a viewer whose UDP is blocked gives up after 15 s."""
_SOON_DAYS: Final = 14
_MOST_BYTES: Final = 10_000


def checked_url(text: str) -> str:
    """Return the page's URL without a slash at its end; raises `ConfigError`."""
    try:
        parts = urlsplit(text if "://" in text else f"https://{text}")
        is_good = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        is_good = False
    if not is_good:
        raise ConfigError(f"--reach: {text} is no address; write it as https://robot.example.org")
    return f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}"


def page(url: str) -> Verdict:
    """Open the page."""
    try:
        # Since Python 3.12 the opener keeps the context of the first request, unless given one.
        context = ssl.create_default_context()
        with urllib.request.urlopen(f"{url}/", timeout=_ANSWER_S, context=context) as answer:
            text = answer.read(10_000).decode(errors="replace")
    except urllib.error.HTTPError as error:
        return bad(
            f"{url} answers, but with {error.code} {error.reason}.",
            "Check the proxy in front, and server.names.",
        )
    except OSError as error:
        return bad(
            f"{url} does not open. {_why(url, error)}",
            "Check that the server runs, that the router forwards the TCP port to it, and the"
            " firewalls on the way.",
        )
    if "WAX" not in text:
        return warning(f"{url} answers, but not with a page of WAX.", "Check where it leads.")
    return ok(f"The page at {url} opens.")


def _why(url: str, error: Exception) -> Sentence:
    target = Target.of(url, _ANSWER_S)
    assert target is not None, "checked_url() comes first"
    return explained(target, error)


def certificate(url: str) -> Verdict:
    """Check how long the certificate at this URL is valid."""
    parts = urlsplit(url)
    host, port = parts.hostname or "", parts.port or 443
    if parts.scheme == "http":
        return warning(
            "The page has no HTTPS: browsers then lack gamepads, and anybody on the way can read"
            " and change it.",
            "Put a proxy with HTTPS in front.",
        )
    try:
        with (
            socket.create_connection((host, port), timeout=_ANSWER_S) as line,
            ssl.create_default_context().wrap_socket(line, server_hostname=host) as secured,
        ):
            found = secured.getpeercert() or {}
    except ssl.SSLCertVerificationError as error:
        seen = ssl.get_server_certificate((host, port), timeout=_ANSWER_S)
        fingerprint = hashlib.sha256(ssl.PEM_cert_to_DER_cert(seen)).digest().hex(":").upper()
        return bad(
            f"The certificate is not trusted. {_why(url, error)} Its SHA-256 fingerprint is"
            f" {fingerprint}.",
            "If the server made it, compare this with the server's own words; browsers ask once.",
        )
    except OSError as error:
        return bad(f"No certificate is shown. {_why(url, error)}", "See the page's verdict above.")
    ends_s = ssl.cert_time_to_seconds(str(found["notAfter"]))
    ends = datetime.datetime.fromtimestamp(ends_s, datetime.UTC)
    left = ends - datetime.datetime.now(datetime.UTC)
    if left.days < _SOON_DAYS:
        return warning(f"The certificate ends on {ends:%Y-%m-%d}, soon.", "Renew it.")
    return ok(f"The certificate is trusted, and valid until {ends:%Y-%m-%d}.")


def viewer(url: str) -> Verdict:
    """Connect as a viewer does, and wait for a picture over UDP."""
    return asyncio.run(_watch(url))


def _ice_servers(url: str) -> list[dict[str, Any]]:
    """Return the page's ICE servers; empty for one-port mode, or if unknown."""
    context = ssl.create_default_context()
    try:
        with urllib.request.urlopen(f"{url}/api/ice", timeout=_ANSWER_S, context=context) as answer:
            told = from_json(answer.read(_MOST_BYTES))
        return list(told["iceServers"]) if told["wantsCandidates"] else []
    except (OSError, ValueError, KeyError, TypeError):
        return []


async def _watch(url: str) -> Verdict:
    servers = await asyncio.to_thread(_ice_servers, url)
    began_s = time.monotonic()
    try:
        async with Client(url, name="wax doctor", sound=False, ice_servers=servers) as client:
            connected_s = time.monotonic() - began_s
            while client.media.newest("video") is None:
                if time.monotonic() - began_s > connected_s + _PICTURE_S:
                    return warning(
                        f"A viewer connects after {connected_s:.1f} s, but gets no picture.",
                        "Look at the page, which says what is wrong with the camera.",
                    )
                await asyncio.sleep(0.05)
            await client.pongs()
            return ok(
                f"A viewer connects after {connected_s:.1f} s and gets the picture;"
                f" a command takes about {client.clock.one_way_s * 1000:.0f} ms."
            )
    except TimeoutError:
        return bad(
            "The page's server answers, but no UDP comes through.",
            "Forward the UDP port of [network] to the server, let it through the firewalls, and set"
            " network.public_addresses; or offer a TURN server. With full ICE, see [network] stun.",
        )
    except SignallingError as error:
        return bad(f"The server lets no viewer in: {error}.", "See the log of the server.")
    except OSError as error:
        why = await asyncio.to_thread(_why, url, error)
        return bad(f"The server cannot be asked. {why}", "See the page's verdict above.")
