"""The two cookies: a browser's identity, and the host's sign-in (RFC 6265bis).

Scripts cannot read them, and only our own page sends them. Under HTTPS their names begin with
``__Host-``, so that no other host of the same domain can set them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.access.access import Shown
from wax.access.host_secrets import COOKIE_S
from wax.access.keyring import is_bound

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aiohttp import web

_IDENTITY: Final = "wax-id"
_HOST: Final = "wax-host"
_BOUND: Final = "__Host-"
_MOST: Final = 200
"""Cookies of a request that are read; browsers keep up to 180 for a site."""
_IDENTITY_S: Final = 365 * 86_400


def shown(headers: Iterable[str], scheme: str) -> Shown:
    """Return our cookies from a request's `Cookie` headers; the first of each name counts.

    Under HTTPS, a name without the prefix counts only where nobody else can have set it: for
    identities from before the prefix was used, and for the host's cookie.
    """
    found = _pairs(headers)
    identity, host = found.get(_IDENTITY), found.get(_HOST)
    if scheme != "https":
        return Shown(identity=identity, host=host)
    bound = found.get(_BOUND + _IDENTITY)
    if bound is None and identity is not None and not is_bound(identity):
        bound = identity
    return Shown(identity=bound, host=found.get(_BOUND + _HOST, host))


def lacks_prefix(headers: Iterable[str], scheme: str) -> bool:
    """Whether a browser's identity lacks the prefix that HTTPS now uses."""
    return scheme == "https" and _BOUND + _IDENTITY not in _pairs(headers)


def set_identity(response: web.StreamResponse, cookie: str, scheme: str) -> None:
    """Set a browser's identity, for a year."""
    _set(response, _IDENTITY, cookie, _IDENTITY_S, scheme)


def set_host(response: web.StreamResponse, cookie: str, scheme: str) -> None:
    """Set a browser's host cookie."""
    _set(response, _HOST, cookie, int(COOKIE_S), scheme)


def _pairs(headers: Iterable[str]) -> dict[str, str]:
    # Not `SimpleCookie`, which takes 40 ms for what fits into the headers of one request.
    found: dict[str, str] = {}
    for pair in ";".join(headers).split(";", _MOST)[:_MOST]:
        name, _, value = pair.partition("=")
        found.setdefault(name.strip(), value.strip().strip('"'))
    return found


def _set(response: web.StreamResponse, name: str, value: str, age_s: int, scheme: str) -> None:
    # Never set it with the page itself: a request from another site's link carries no cookie, and
    # a new identity would replace the old one.
    is_secure = scheme == "https"
    if is_secure:
        response.del_cookie(name, path="/", secure=True, httponly=True, samesite="Strict")
    response.set_cookie(
        f"{_BOUND}{name}" if is_secure else name,
        value,
        max_age=age_s,
        path="/",
        httponly=True,
        samesite="Strict",
        secure=is_secure,
    )
