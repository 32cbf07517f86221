"""The two cookies: who a browser is, and whether it is the host's (RFC 6265bis).

Both are out of reach of scripts, are sent only by our own page, and under HTTPS by HTTPS only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.access.access import Shown
from wax.access.host_secrets import COOKIE_S

if TYPE_CHECKING:
    from aiohttp import web

_IDENTITY: Final = "wax-id"
_HOST: Final = "wax-host"
_IDENTITY_S: Final = 365 * 86_400


def shown(request: web.Request) -> Shown:
    """Return what a request shows."""
    cookies = request.cookies
    return Shown(identity=cookies.get(_IDENTITY), host=cookies.get(_HOST))


def give_identity(response: web.StreamResponse, cookie: str, scheme: str) -> None:
    """Let a browser be who the cookie says, for a year."""
    _set(response, _IDENTITY, cookie, _IDENTITY_S, scheme)


def give_host(response: web.StreamResponse, cookie: str, scheme: str) -> None:
    """Let a browser be the host's."""
    _set(response, _HOST, cookie, int(COOKIE_S), scheme)


def _set(response: web.StreamResponse, name: str, value: str, age_s: int, scheme: str) -> None:
    # Not with the page itself: on the way from another site's link no cookie comes, and a new
    # identity would replace the old one.
    response.set_cookie(
        name,
        value,
        max_age=age_s,
        path="/",
        httponly=True,
        samesite="Strict",
        secure=scheme == "https",
    )
