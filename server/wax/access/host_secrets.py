"""The host is who holds a secret: a link that works once, then a cookie that changes with each use.

Only hashes are kept, so that the records let nobody in.
"""

from __future__ import annotations

import hashlib
import secrets
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

LINK_S: Final = 86_400.0
"""A link that nobody has used ends after a day."""
COOKIE_S: Final = 30 * 86_400.0
OVERLAP_S: Final = 60.0
"""The previous cookie is good for so long: another tab may be using it right now."""
_MOST_LINKS: Final = 8


class HostSecrets:
    """The links and cookies in force, by their hashes, with the times (since 1970) when they end.

    `keep` is called with each cookie's hash and its end, and again when that changes.
    """

    def __init__(
        self, kept: Iterable[tuple[str, float]], keep: Callable[[str, float], None]
    ) -> None:
        self._links: dict[str, float] = {}
        self._cookies = dict(kept)
        self._keep = keep

    def new_link(self, now_s: float) -> str:
        """Return the secret of a link that makes whoever opens it first the host."""
        secret = secrets.token_urlsafe(24)
        self._links[_hash(secret)] = now_s + LINK_S
        while len(self._links) > _MOST_LINKS:
            del self._links[next(iter(self._links))]
        return secret

    def exchange(self, secret: str, now_s: float) -> str | None:
        """Return a cookie for a link's secret, once; None if it is unknown, used or over."""
        ends_s = self._links.pop(_hash(secret), None)
        if ends_s is None or now_s >= ends_s:
            return None
        return self._new_cookie(now_s)

    def is_host(self, cookie: str | None, now_s: float) -> bool:
        """Whether this cookie is the host's."""
        return cookie is not None and now_s < self._cookies.get(_hash(cookie), 0.0)

    def rotate(self, cookie: str, now_s: float) -> str | None:
        """Return the cookie that replaces this one; None if it is over or was replaced already."""
        name = _hash(cookie)
        ends_s = self._cookies.get(name, 0.0)
        if now_s + OVERLAP_S >= ends_s:
            return None
        self._set(name, now_s + OVERLAP_S)
        return self._new_cookie(now_s)

    def _new_cookie(self, now_s: float) -> str:
        for name in [one for one, ends_s in self._cookies.items() if now_s >= ends_s]:
            del self._cookies[name]
        cookie = secrets.token_urlsafe(32)
        self._set(_hash(cookie), now_s + COOKIE_S)
        return cookie

    def _set(self, name: str, ends_s: float) -> None:
        self._cookies[name] = ends_s
        self._keep(name, ends_s)


def _hash(secret: str) -> str:
    # A header's bytes that are not UTF-8 come as surrogates (PEP 383).
    return hashlib.sha256(secret.encode(errors="backslashreplace")).hexdigest()
