"""Checks every request: is it for this server, and may the page that sent it do so?"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

import structlog
from aiohttp import HttpVersion10, web

from wax.errors import NotForUsError
from wax.sentence import Sentence
from wax.web.connection import Connection
from wax.web.host_names import HostNames, host_of
from wax.web.security_headers import UNDER_HTTPS, base_headers
from wax.web.senders import Proxies, Seen, is_same_origin, is_same_site
from wax.web.sparse_log import SparseLog

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping, Sequence

    from aiohttp.typedefs import Middleware

    from wax.clock import Clock
    from wax.config.server import ServerSettings

    Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

_LOG = structlog.get_logger(__name__)

_READING: Final = ("GET", "HEAD")
_HEALTH: Final = ("/healthz", "/readyz")
_SEEN: Final = web.RequestKey("seen", Seen)

_ANY_OPENER: Final = "unsafe-none"
"""For pages that ours open: what a frame with ``sandbox`` opens may have no other policy."""

_NOT_OURS: Final = Sentence("request.other_name")
_NO_NAME: Final = Sentence("request.no_name")
_OTHER_SITE: Final = Sentence("request.other_site")
_OTHER_ORIGIN: Final = Sentence("request.other_origin")
_OTHER_THAN_PROXY: Final = Sentence(
    "request.other_than_proxy",
    {"apache": "RequestHeader set X-Forwarded-Proto expr=%{REQUEST_SCHEME}"},
)

_BROKEN: Final = Sentence("request.broken")


class Guards:
    """Make one for each server; add its `middlewares`, and call `add_headers` on each response.

    `public_addresses` returns the router's, which this machine goes by, too; the page may connect
    to `room_urls` besides.
    """

    def __init__(
        self,
        server: ServerSettings,
        clock: Clock,
        public_addresses: Callable[[], Collection[str]] = tuple,
        room_urls: Collection[str] = (),
    ) -> None:
        self._headers = base_headers(room_urls)
        self._public_addresses = public_addresses
        listening = [] if server.host in ("0.0.0.0", "::") else [server.host]
        self._names = HostNames([*server.all_names, *listening])
        # Browsers apply HSTS to all ports of a name: not for localhost, where others serve, too.
        self._public = frozenset(server.all_names)
        self._proxies = Proxies(server.trusted_proxies)
        self._clock = clock
        self._log = SparseLog(_LOG, clock)

    @property
    def middlewares(self) -> tuple[Middleware, ...]:
        """Put them right after the one that turns exceptions into answers, before all others."""

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            connection = request.protocol
            if not isinstance(connection, Connection):
                return await guarded(request, handler)
            if not connection.header_parsed(request):
                raise NotForUsError(_BROKEN, 400)
            return await connection.timed(guarded(request, handler))

        async def guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
            self._check(request)
            try:
                return await handler(request)
            except (ConnectionError, web.RequestPayloadError):
                raise NotForUsError(_BROKEN, 400) from None

        return (guard,)

    def seen(self, request: web.Request) -> Seen:
        """Return a request's sender and how they address us; raises `NotForUsError` if unclear."""
        seen = request.get(_SEEN)
        if seen is None:
            # Until the sender is clear, it is the proxy: answers to errors need one, too.
            request[_SEEN] = self._proxies.direct(request)
            seen = request[_SEEN] = self._proxies.seen(request)
        return seen

    def frame_policy(self, sites: Iterable[str]) -> str:
        """Return the content policy that lets these sites show a page in a frame."""
        return " ".join([self._headers["Content-Security-Policy"], *sites])

    def sender(self, request: web.Request) -> str:
        """Return the sender of a request, for limits: an IPv4 address or an IPv6 /64 prefix."""
        return self.seen(request).sender

    def said(self, request: web.Request, asked: Iterable[str]) -> Mapping[str, Sequence[str]]:
        """Return what a trusted proxy says in these headers; nothing from anybody else."""
        if not self._proxies.trusts(request.remote or ""):
            return {}
        return {name: request.headers.getall(name, ()) for name in asked}

    async def add_headers(self, request: web.Request, response: web.StreamResponse) -> None:
        """Add the security headers, and a `Server` that names no library or version."""
        response.headers["Server"] = "WAX"
        if request.headers.get("Sec-Fetch-Site") == "same-origin":
            response.headers["Cross-Origin-Opener-Policy"] = _ANY_OPENER
        for name, value in self._headers.items():
            response.headers.setdefault(name, value)
        seen = self.seen(request)
        if seen.scheme == "https" and seen.name in self._public:
            for name, value in UNDER_HTTPS.items():
                response.headers.setdefault(name, value)
        if request.path.startswith("/assets/") and response.status < 400:
            response.headers.setdefault("Cache-Control", "public, max-age=31536000, immutable")
        elif request.path.startswith("/api/"):
            response.headers.setdefault("Cache-Control", "no-store")

    def _check(self, request: web.Request) -> None:
        """Raise `NotForUsError` if the request must not be answered."""
        seen = self.seen(request)
        try:
            host = host_of(seen.host)
            # A request through a proxy can name a host in its target, too (RFC 9112, 3.2.2).
            named = None if request.raw_path.startswith("/") else urlsplit(request.raw_path).netloc
            target = host_of(named) if named else host
        except ValueError:
            if not seen.host and _is_check_of_health(request):
                return
            self._refused(request, "malformed host")
            raise NotForUsError(_NO_NAME, 400) from None
        if not (self._is_ours(host) and self._is_ours(target)):
            self._refused(request, "not our name", host=host)
            raise NotForUsError(_NOT_OURS, 421)
        if "\0" in request.path:
            raise NotForUsError(Sentence("request.no_page"), 404)
        if request.method not in _READING and not is_same_origin(request, seen.origin):
            self._refused(request, "another site's page", ours=seen.origin)
            raise NotForUsError(self._other_page(request), 403)

    def _other_page(self, request: web.Request) -> Sentence:
        """Return why a request that changes state does not count as our page's."""
        if not is_same_site(request):
            return _OTHER_SITE
        is_known = self._proxies.trusts(request.remote or "")
        return _OTHER_THAN_PROXY if is_known else _OTHER_ORIGIN

    def _is_ours(self, host: str) -> bool:
        return self._names.knows(host, self._clock.now_s()) or host in self._public_addresses()

    def _refused(self, request: web.Request, why: str, **values: str) -> None:
        self._log.info("request refused", why=why, sender=self.sender(request), **values)


def _is_check_of_health(request: web.Request) -> bool:
    """Whether a load balancer asks, as HAProxy does; browsers always name a host."""
    is_old = request.version <= HttpVersion10
    return is_old and request.method in _READING and request.path in _HEALTH
