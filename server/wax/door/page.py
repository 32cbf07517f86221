"""Checks from here whether the page opens at its public address; blocks."""

from __future__ import annotations

import email.utils
import http.client
import ssl
import urllib.error
import urllib.request
from typing import Final

from wax.door.over_https import PATH
from wax.logs.printable import printable
from wax.second_look import explained
from wax.sentence import Sentence, says
from wax.unreachable import Target, is_certificate

_ANSWER_S: Final = 5.0
_MOST_BYTES: Final = 1000
CLOCK_OFF_S: Final = 300.0
"""Half of the lifetime of the relay's passwords."""
_MOST_CHARS: Final = 120


def check_page(url: str, wall_s: float, here: str | None) -> Sentence | None:
    """Return what is wrong with the page at `url`, None if nothing; `wall_s` is Unix time.

    `here` is the local address of the server that should answer there, None if it does not run.
    """
    problem = None
    try:
        there = _identity(url)
        if _own_identity(here) not in (None, there):
            problem = Sentence("tunnel.another", {"url": url})
    except urllib.error.HTTPError as error:
        problem = _unopened(url, f"{error.code} {error.reason}")
    except (OSError, ValueError, http.client.HTTPException) as error:
        problem = _not_reached(url, error)
    off_s = _clock_off_s(url, wall_s)
    if off_s is not None and abs(off_s) > CLOCK_OFF_S:
        return Sentence("tunnel.clock", {"n": round(abs(off_s) / 60)})
    return problem


def _identity(url: str) -> bytes:
    """Return an answer that is unique to the server and to this run of it."""
    with _get(f"{url}/healthz", ssl.create_default_context()) as answer:
        return answer.read(_MOST_BYTES)


def _own_identity(here: str | None) -> bytes | None:
    """Return the identity of the server at `here`; None if it does not answer."""
    try:
        return None if here is None else _identity(f"http://{here}")
    except (OSError, ValueError, http.client.HTTPException):
        return None


def _clock_off_s(url: str, wall_s: float) -> float | None:
    """Return by how much our clock is ahead of the door's, which answers this path itself.

    The certificate is not verified: to a wrong clock, none is valid.
    """
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with _get(url + PATH, context) as answer:
            date = answer.headers["Date"]
    except urllib.error.HTTPError as error:
        date = error.headers["Date"]
    except (OSError, ValueError, http.client.HTTPException):
        return None
    try:
        return wall_s - email.utils.parsedate_to_datetime(date or "").timestamp()
    except (ValueError, OverflowError):
        return None


def _unopened(url: str, why: str) -> Sentence:
    """Return the problem, with a reason that a stranger's server may have written."""
    return Sentence("tunnel.page", {"url": url, "why": says(printable(why, _MOST_CHARS))})


def _not_reached(url: str, error: Exception) -> Sentence:
    target = Target.of(url, _ANSWER_S)
    if target is None:
        return _unopened(url, type(error).__name__)
    return Sentence(
        "tunnel.certificate" if is_certificate(error) else "tunnel.not_reached",
        {"url": url, "why": explained(target, error)},
    )


class _NoRedirects(urllib.request.HTTPRedirectHandler):
    """Follows no redirect: it would not lead to this robot's page, but perhaps into its network."""

    def redirect_request(self, *_: object) -> None:
        return None


def _get(url: str, context: ssl.SSLContext) -> http.client.HTTPResponse:
    handlers = urllib.request.HTTPSHandler(context=context), urllib.request.ProxyHandler({})
    opener = urllib.request.build_opener(*handlers, _NoRedirects)
    answer: http.client.HTTPResponse = opener.open(url, timeout=_ANSWER_S)
    return answer
