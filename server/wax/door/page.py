"""Whether the page opens at its public address, as asked from here; blocks."""

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
"""Half of what the relay's passwords last."""
_MOST_CHARS: Final = 120


def look(url: str, wall_s: float, here: str | None) -> Sentence | None:
    """Return what is wrong with the page at `url`, None if nothing; `wall_s` is Unix time.

    `here` is the address of the server that should answer there, None if it does not run.
    """
    problem = None
    try:
        there = _who(url)
        if _mine(here) not in (None, there):
            problem = Sentence("tunnel.another", {"url": url})
    except urllib.error.HTTPError as error:
        problem = _unopened(url, f"{error.code} {error.reason}")
    except (OSError, ValueError, http.client.HTTPException) as error:
        problem = _not_reached(url, error)
    off_s = _clock_off_s(url, wall_s)
    if off_s is not None and abs(off_s) > CLOCK_OFF_S:
        return Sentence("tunnel.clock", {"n": round(abs(off_s) / 60)})
    return problem


def _who(url: str) -> bytes:
    """Return what only one server answers, each time it runs."""
    with _get(f"{url}/healthz", ssl.create_default_context()) as answer:
        return answer.read(_MOST_BYTES)


def _mine(here: str | None) -> bytes | None:
    """Return what the server at `here` answers; None if that is not to be had just now."""
    try:
        return None if here is None else _who(f"http://{here}")
    except (OSError, ValueError, http.client.HTTPException):
        return None


def _clock_off_s(url: str, wall_s: float) -> float | None:
    """Return by how much our clock is ahead of the door's, which answers this path itself.

    Whoever has the wrong time believes no certificate, so none is asked for.
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
    """Return the problem; whoever answers there may have written the reason."""
    return Sentence("tunnel.page", {"url": url, "why": says(printable(why, _MOST_CHARS))})


def _not_reached(url: str, error: Exception) -> Sentence:
    target = Target.of(url, _ANSWER_S)
    if target is None:
        return _unopened(url, type(error).__name__)
    return Sentence(
        "tunnel.certificate" if is_certificate(error) else "tunnel.not_reached",
        {"url": url, "why": explained(target, error)},
    )


class _Stay(urllib.request.HTTPRedirectHandler):
    """Follows nobody: a page that leads elsewhere is not this robot's, and may lead into here."""

    def redirect_request(self, *_: object) -> None:
        return None


def _get(url: str, context: ssl.SSLContext) -> http.client.HTTPResponse:
    handlers = urllib.request.HTTPSHandler(context=context), urllib.request.ProxyHandler({})
    opener = urllib.request.build_opener(*handlers, _Stay)
    answer: http.client.HTTPResponse = opener.open(url, timeout=_ANSWER_S)
    return answer
