"""A host is known by a secret: a link that works once, then a cookie that rotates with each use.

The cookies that replace each other are one sign-in, and end together. If a replaced cookie is used
again, somebody may have stolen a copy (RFC 9700, 4.14.2); this detects the newest ones replaced
since the server's start. Only hashes are stored, so the records let nobody in.
"""

from __future__ import annotations

import hashlib
import secrets
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from wax.bounded_dict import BoundedDict

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

LINK_S: Final = 86_400.0
"""An unused link expires after a day."""
COOKIE_S: Final = 30 * 86_400.0
OVERLAP_S: Final = 60.0
"""How long the previous cookie stays valid: another tab may be using it right now."""
_MOST_LINKS: Final = 8
_MOST_REPLACED: Final = 1024


@dataclass(frozen=True, slots=True)
class _Cookie:
    ends_s: float
    sign_in: str


class HostSecrets:
    """The hashes of valid links and cookies, with their expiry (seconds since 1970).

    `keep` stores each cookie's hash and expiry, and is called again when that changes.
    """

    def __init__(
        self, kept: Iterable[tuple[str, float]], keep: Callable[[str, float], None]
    ) -> None:
        self._links = BoundedDict[str, float](_MOST_LINKS)
        # Which cookies of an earlier run belong together is unknown: each is its own sign-in.
        self._cookies = {name: _Cookie(ends_s, name) for name, ends_s in kept}
        self._replaced = BoundedDict[str, str](_MOST_REPLACED)  # hash to sign-in
        self._keep = keep

    def new_link(self, now_s: float) -> str:
        """Return the secret of a link that makes the first person who opens it host."""
        secret = secrets.token_urlsafe(24)
        self._links[_hash(secret)] = now_s + LINK_S
        return secret

    def exchange(self, secret: str, now_s: float) -> str | None:
        """Return a cookie for a link's secret, once; None if it is unknown, used or expired."""
        ends_s = self._links.pop(_hash(secret), None)
        if ends_s is None or now_s >= ends_s:
            return None
        return self._new_cookie(now_s)

    def sign_in(self, cookie: str | None, now_s: float) -> str:
        """Return the sign-in of this cookie; empty if it is no valid cookie of a host."""
        found = None if cookie is None else self._cookies.get(_hash(cookie))
        return "" if found is None or now_s >= found.ends_s else found.sign_in

    def is_signed_in(self, sign_in: str, now_s: float) -> bool:
        """Whether a sign-in is valid."""
        return any(one.sign_in == sign_in and now_s < one.ends_s for one in self._cookies.values())

    def was_replaced(self, cookie: str, now_s: float) -> bool:
        """Whether this cookie was replaced by one that is still valid."""
        return self.is_signed_in(self._replaced.get(_hash(cookie), ""), now_s)

    def sign_out_others(self, sign_in: str) -> int:
        """End all other sign-ins and all unused links; return how many sign-ins ended."""
        self._links.clear()
        others = [name for name, one in self._cookies.items() if one.sign_in != sign_in]
        ended = {self._cookies.pop(name).sign_in for name in others}
        for name in others:
            self._keep(name, 0.0)
        return len(ended)

    def rotate(self, cookie: str, now_s: float) -> str | None:
        """Return the cookie that replaces this one; None if it has expired or been replaced."""
        name = _hash(cookie)
        found = self._cookies.get(name)
        if found is None or now_s + OVERLAP_S >= found.ends_s:
            return None
        self._set(name, replace(found, ends_s=now_s + OVERLAP_S))
        self._replaced[name] = found.sign_in
        return self._new_cookie(now_s, found.sign_in)

    def _new_cookie(self, now_s: float, sign_in: str = "") -> str:
        for name in [name for name, one in self._cookies.items() if now_s >= one.ends_s]:
            del self._cookies[name]
        cookie = secrets.token_urlsafe(32)
        name = _hash(cookie)
        self._set(name, _Cookie(now_s + COOKIE_S, sign_in or name))
        return cookie

    def _set(self, name: str, cookie: _Cookie) -> None:
        self._cookies[name] = cookie
        self._keep(name, cookie.ends_s)


def _hash(secret: str) -> str:
    # Bytes of a header that are not UTF-8 arrive as surrogates (PEP 383).
    return hashlib.sha256(secret.encode(errors="backslashreplace")).hexdigest()
