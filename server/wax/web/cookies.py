"""The two cookies: who a browser is, and whether it is the host's (RFC 6265bis).

Both are out of reach of scripts and are sent only by our own page. Under HTTPS their names begin
with ``__Host-``, so that no neighbour under another name of the same domain can set them.
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
"""So many cookies of a request are looked at; browsers keep up to 180 for a site."""
_IDENTITY_S: Final = 365 * 86_400


def shown(headers: Iterable[str], scheme: str) -> Shown:
    """Return what the `Cookie` headers of a request show; of several the first counts.

    Under HTTPS the plain names count where nobody else can have set them: identities that were
    given before there were others, and the host's.
    """
    found = _pairs(headers)
    identity, host = found.get(_IDENTITY), found.get(_HOST)
    if scheme != "https":
        return Shown(identity=identity, host=host)
    bound = found.get(_BOUND + _IDENTITY)
    if bound is None and identity is not None and not is_bound(identity):
        bound = identity
    return Shown(identity=bound, host=found.get(_BOUND + _HOST, host))


def to_rename(headers: Iterable[str], scheme: str) -> bool:
    """Whether the identity that a browser shows has a name that HTTPS no longer uses."""
    return scheme == "https" and _BOUND + _IDENTITY not in _pairs(headers)


def give_identity(response: web.StreamResponse, cookie: str, scheme: str) -> None:
    """Let a browser be who the cookie says, for a year."""
    _set(response, _IDENTITY, cookie, _IDENTITY_S, scheme)


def give_host(response: web.StreamResponse, cookie: str, scheme: str) -> None:
    """Let a browser be the host's."""
    _set(response, _HOST, cookie, int(COOKIE_S), scheme)


def _pairs(headers: Iterable[str]) -> dict[str, str]:
    # Not `SimpleCookie`, which takes 40 ms for what fits into the headers of one request.
    found: dict[str, str] = {}
    for pair in ";".join(headers).split(";", _MOST)[:_MOST]:
        name, _, value = pair.partition("=")
        found.setdefault(name.strip(), value.strip().strip('"'))
    return found


def _set(response: web.StreamResponse, name: str, value: str, age_s: int, scheme: str) -> None:
    # Not with the page itself: on the way from another site's link no cookie comes, and a new
    # identity would replace the old one.
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
