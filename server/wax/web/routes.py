"""The HTTP routes, with the rate limits of each and of wrong secrets."""

from __future__ import annotations

import hashlib
import secrets
import zlib
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from html import escape
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

import structlog
from aiohttp import web

from wax.access import permissions
from wax.access.access import Shown
from wax.access.admission import Visitor
from wax.errors import (
    HTTP_STATUS,
    ForbiddenError,
    FullError,
    NoPlaceError,
    NotAdmittedError,
    NotForUsError,
    ProtocolError,
    StartError,
    TooOftenError,
    WaxError,
)
from wax.protocol import foreign_json
from wax.protocol.http_bodies import (
    MAX_BODY_BYTES,
    Done,
    EntryAnswer,
    EntryBody,
    HostLink,
    Lifted,
    OfferAnswer,
    OfferBody,
    QueueBody,
    RequestBody,
    SeatBody,
    StopAnswer,
    StopPress,
    StopRelease,
)
from wax.rate_limits import TokenBuckets
from wax.sentence import Sentence, says
from wax.web import cookies
from wax.web.branding import PICTURE_PATH, STYLE_PATH
from wax.web.built_page import BuiltPage, cache_headers
from wax.web.oembed import OEMBED_PATH, VIEW
from wax.web.page_urls import is_loopback
from wax.web.request_budgets import HOST
from wax.web.security_headers import policy_of_document

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator, Mapping

    from aiohttp.typedefs import Middleware
    from pydantic import BaseModel

    from wax.rtc.ice_servers import IceServers
    from wax.session.parts import Parts
    from wax.session.proof_runner import ProofRunner
    from wax.session.room import Room
    from wax.web.branding import BrandedPage
    from wax.web.guards import Guards
    from wax.web.opening_calendar import OpeningCalendar

    Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

_LOG = structlog.get_logger(__name__)

_LONGEST_QUERY: Final = 1024
"""The limit of a question about a link; ours is shorter than 300."""
_GZIP: Final = 16
"""Added to zlib's number for the window, it means gzip."""

_OFFERS_BURST_S: Final = 20
"""A class behind one router connects at once, and each answer takes 10 ms of CPU."""
_ASKS_PER_OFFER: Final = 10
"""A request for a seat or the queue costs at most a tenth of an answer's CPU; a page that watches
in a LiveKit room sends one every four minutes, one that waits every five seconds."""
_OWN_HZ: Final = 1.0
_OWN_BURST: Final = 10
"""For somebody in the room: as often as a page reconnects after losing its connection."""
_FAILURES_HZ: Final = 0.2
_FAILURES_BURST: Final = 10
"""Per address: failed tries of a secret or an invitation, which nobody could guess anyway."""
_MAX_ADDRESSES: Final = 1024
_ASSET: Final = "/{path:.+}"
_EMBED: Final = "/api/embed"
_STOP: Final = "POST /api/stop"
_URGENT: Final = frozenset({_STOP, "POST /api/release"})
"""From anybody with the permission; they pass others' requests."""
_VISITOR: Final = web.RequestKey("visitor", Visitor)
_TAB: Final = "WAX-Tab"
"""The header that lets a page press Stop if its browser allows no cookie."""

PAGE: Final = Path(__file__).parent / "dist"


_Body = TypeVar("_Body", bound=RequestBody)


class Routes:
    """Answers HTTP; `status` returns the status page's JSON, `missing` what is not ready.

    `calendar` has the opening hours, and is None if the robot is always open.
    """

    def __init__(
        self,
        parts: Parts,
        room: Room,
        *,
        ice: IceServers,
        status: Callable[[], dict[str, object]],
        proving: ProofRunner,
        branding: BrandedPage,
        guards: Guards,
        missing: Callable[[], dict[str, str]],
        calendar: OpeningCalendar | None = None,
    ) -> None:
        self._guards = guards
        self._access = parts.access
        self._room = room
        self._clock = parts.clock
        offers_hz = parts.settings.server.max_offers_per_address_hz
        self._offers = TokenBuckets(
            rate_hz=offers_hz, burst=ceil(offers_hz * _OFFERS_BURST_S), most=_MAX_ADDRESSES
        )
        self._again_s = ceil(1 / offers_hz)
        asks_hz = _ASKS_PER_OFFER * offers_hz
        self._asks = TokenBuckets(
            rate_hz=asks_hz, burst=ceil(asks_hz * _OFFERS_BURST_S), most=_MAX_ADDRESSES
        )
        self._own = TokenBuckets(rate_hz=_OWN_HZ, burst=_OWN_BURST, most=_MAX_ADDRESSES)
        self._failures = TokenBuckets(
            rate_hz=_FAILURES_HZ, burst=_FAILURES_BURST, most=_MAX_ADDRESSES
        )
        self._warned: set[str] = set()
        self._proof_runner = proving
        self._ice = ice
        self._run = secrets.token_hex(8)
        self._status = status
        self._branding = branding
        self._missing = missing
        self._calendar = calendar

    def application(self) -> web.Application:
        """Make the application; raises `StartError` if the page was not built."""
        try:
            self._built = BuiltPage(PAGE, self._branding, self._calendar)
        except OSError as error:
            raise StartError(
                "the page is not built; run `make run`, or `pip install .` again"
            ) from error
        application = web.Application(
            client_max_size=MAX_BODY_BYTES,
            middlewares=[_tell_errors, *self._guards.middlewares, self._permission],
        )
        application.on_response_prepare.append(self._guards.add_headers)
        application.add_routes(
            [
                web.get("/", self.page),
                web.get(STYLE_PATH, self.style),
                web.get(PICTURE_PATH, self.preview),
                web.get("/open.ics", self.calendar),
                web.get(OEMBED_PATH, self.oembed),
                web.get("/healthz", self.health),
                web.get("/readyz", self.readiness),
                web.get("/api/status", self.status),
                web.get("/api/ice", self.ice),
                web.get("/api/present", self.present),
                web.post("/api/host", self.become_host),
                web.post("/api/enter", self.enter),
                web.post("/api/offer", self.offer),
                web.post(_EMBED, self.embed),
                web.post("/api/queue", self.queue),
                web.post("/api/seat", self.seat),
                web.post("/api/stop", self.stop),
                web.post("/api/release", self.release),
                web.post("/api/proof", self.prove),
                web.get("/api/proof", self.proof),
                web.get("/api/proof/record", self.record),
                web.get(_ASSET, self.asset),
            ]
        )
        return application

    async def page(self, request: web.Request) -> web.StreamResponse:
        # Looked for, not parsed: of 8 KB that would take milliseconds.
        is_embed = f"view={VIEW}" in request.query_string.split("&")
        policy = self._guards.frame_policy(self._branding.embed_on) if is_embed else None
        return await self._built.page(request, self._guards.seen(request).origin, policy)

    async def asset(self, request: web.Request) -> web.StreamResponse:
        sent = partial(self._room.file_sent, request[_VISITOR])
        return await self._built.asset(request, request.match_info["path"], sent)

    async def style(self, request: web.Request) -> web.Response:
        """Answer with the host's colours; without any, the page keeps its own."""
        own = self._branding
        headers = cache_headers(request, own.style_digest)
        return web.Response(text=own.style, content_type="text/css", headers=headers)

    async def preview(self, request: web.Request) -> web.StreamResponse:
        return await self._built.preview(request)

    async def calendar(self, request: web.Request) -> web.StreamResponse:
        return await self._built.calendar(request)

    async def oembed(self, request: web.Request) -> web.Response:
        if len(request.query_string) > _LONGEST_QUERY:
            raise NotForUsError(Sentence("request.no_page"), 404)
        answer = self._branding.oembed(request.query, self._guards.seen(request).origin)
        return web.json_response(answer, headers={"Cache-Control": "public, max-age=3600"})

    async def health(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return web.json_response({"ok": True, "run": self._run})

    async def readiness(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        # The parts only: the reasons are for the host, in the status.
        missing = sorted(self._missing())
        answer = {"ready": not missing, "reasons": missing}
        return web.json_response(answer, status=503 if missing else 200)

    async def status(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return web.json_response(self._status())

    async def ice(self, request: web.Request) -> web.Response:
        self._access.admit(request[_VISITOR])  # a relay costs traffic: it is for viewers only
        told = self._ice.for_page(secrets.token_hex(4), self._clock.wall_ms() / 1000)
        return _json(told)

    async def present(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        """Answer a page that shows that a proxy still lets it through, as each request does."""
        return _json(Done())

    async def become_host(self, request: web.Request) -> web.Response:
        secret = (await _body(request, HostLink)).secret
        with self._limiting_failures(request):
            cookie = self._access.become_host(secret)
        response = _json(Done())
        cookies.set_host(response, cookie, self._guards.seen(request).scheme)
        self._warn_of_plain_http(request)
        return response

    async def enter(self, request: web.Request) -> web.Response:
        token = (await _body(request, EntryBody)).token
        response, visitor = self._identified(request)
        with self._limiting_failures(request):
            invitation = self._access.enter(token, visitor.identity)
        response.text = EntryAnswer(purpose=invitation.purpose).model_dump_json()
        return response

    async def offer(self, request: web.Request) -> web.Response:
        self._limit(request, self._offers)
        offer = await _body(request, OfferBody)
        response, visitor = self._identified(request)
        try:
            answer = await self._negotiate(visitor, offer.client, offer)
        except NoPlaceError as error:
            seat = self._room.rooms.seat_instead(visitor, offer.client, error)
            response.text = seat.model_dump_json()
            return response
        # The host's page says more about why a connection fails.
        response.text = OfferAnswer(sdp=answer, host=visitor.is_host).model_dump_json()
        response.enable_compression()
        if visitor.is_host:
            self._renew(request, response)
        return response

    async def _negotiate(self, visitor: Visitor, tab: str, offer: OfferBody) -> str:
        if offer.answers:
            await self._room.accept(visitor, tab, offer.sdp)
            return ""
        return await self._room.answer(visitor, tab, offer.sdp)

    async def embed(self, request: web.Request) -> web.Response:
        """Answer a page in another site's frame, which may only watch, whoever's browser it is.

        It is identified by a secret of its own, not by a cookie; only a hash of it is kept.
        """
        self._limit(request, self._offers)
        offer = await _body(request, OfferBody)
        known_by = hashlib.sha256(offer.client.encode()).hexdigest()
        visitor = Visitor(f"embed {known_by}", request[_VISITOR].address, is_embed=True)
        answer = await self._negotiate(visitor, "", offer)
        response = _json(OfferAnswer(sdp=answer))
        response.enable_compression()
        return response

    async def queue(self, request: web.Request) -> web.Response:
        self._limit(request, self._asks)
        queue = await _body(request, QueueBody)
        response, visitor = self._identified(request)
        line = self._room.queue.request(visitor, queue.client, queue.wants, queue.name)
        response.text = line.model_dump_json()
        return response

    async def seat(self, request: web.Request) -> web.Response:
        self._limit(request, self._asks)
        seat = await _body(request, SeatBody)
        response, visitor = self._identified(request)
        if seat.leaves:
            self._room.rooms.leave(visitor, seat.client)
        else:
            response.text = self._room.rooms.seat(visitor, seat.client).model_dump_json()
        return response

    async def stop(self, request: web.Request) -> web.Response:
        press = await _body(request, StopPress)
        number = self._room.stop_by(request[_VISITOR], press.client, press.press)
        return _json(StopAnswer(stop=number))

    async def release(self, request: web.Request) -> web.Response:
        release = await _body(request, StopRelease)
        self._room.release_by(request[_VISITOR], release.client, release.stop)
        return _json(Done())

    async def prove(self, request: web.Request) -> web.Response:
        await _body(request, Lifted)
        await self._proof_runner.start()
        return _json(self._proof_runner.progress(), status=202)

    async def proof(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return _json(self._proof_runner.progress())

    async def record(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        text = self._proof_runner.record()
        headers = {"Content-Security-Policy": policy_of_document(text)}
        return web.Response(text=text, content_type="text/html", headers=headers)

    # --- identity and rate limits ------------------------------------------------------------

    @property
    def _permission(self) -> Middleware:
        """Check every route against the permission table."""

        @web.middleware
        async def check(request: web.Request, handler: Handler) -> web.StreamResponse:
            resource = request.match_info.route.resource
            is_embed = resource is not None and resource.canonical == _EMBED
            shown = Shown() if is_embed else self._shown(request)
            route = ""
            if resource is not None:  # otherwise there is no such page
                path = "/assets" if resource.canonical == "/{path}" else resource.canonical
                route = f"{'GET' if request.method == 'HEAD' else request.method} {path}"
            tab = request.headers.get(_TAB, "")
            visitor = self._visitor(shown, self._guards.sender(request), route, tab)
            if visitor.vouched is not None:
                self._room.renew(visitor)
            if route:
                permissions.check(self._room.role_of(visitor), route)
            request[_VISITOR] = visitor
            return await handler(request)

        return check

    def _visitor(self, shown: Shown, address: str, route: str, tab: str) -> Visitor:
        """Return who sends these cookies; for a Stop without any, the guest whose tab it is."""
        visitor = self._access.visitor(shown, address)
        if route == _STOP and not (visitor.identity or visitor.is_host):
            return self._room.by_tab(visitor, tab)
        return visitor

    def who(self, shown: Shown, address: str, route: str, tab: str) -> tuple[str, bool] | None:
        """Return who sends these cookies, by name, and whether their request is urgent.

        None for anybody outside the room.
        """
        visitor = self._visitor(shown, address, route, tab)
        if visitor.is_host:
            return HOST, True
        role = self._room.role_of(visitor)
        if role == "stranger":
            return None
        return visitor.identity, route in _URGENT and permissions.may(role, route)

    def _shown(self, request: web.Request) -> Shown:
        headers = request.headers.getall("Cookie", ())
        shown = cookies.shown(headers, self._guards.seen(request).scheme)
        return replace(shown, said=self._guards.said(request, self._access.asked))

    def _identified(self, request: web.Request) -> tuple[web.Response, Visitor]:
        """Return a response that sets a cookie if the request has none, and whose browser it is.

        Raises `NotAdmittedError` if a proxy should say who this is, and does not.
        """
        response = web.json_response({})
        shown, scheme = self._shown(request), self._guards.seen(request).scheme
        known = self._access.identity_of(shown)
        if known is not None:
            if cookies.lacks_prefix(request.headers.getall("Cookie", ()), scheme):
                cookies.set_identity(response, str(shown.identity), scheme)
            return response, self._access.on_device(request[_VISITOR], known)
        cookie = self._access.new_identity(bound=scheme == "https")
        cookies.set_identity(response, cookie, scheme)
        made = self._access.identity_of(Shown(cookie))
        assert made is not None
        return response, self._access.on_device(request[_VISITOR], made)

    def _renew(self, request: web.Request, response: web.Response) -> None:
        cookie = self._access.renew_cookie(self._shown(request))
        if cookie is not None:
            cookies.set_host(response, cookie, self._guards.seen(request).scheme)
        self._warn_of_plain_http(request)

    def _limit(self, request: web.Request, buckets: TokenBuckets) -> None:
        """Refuse an address or a known person over the rate limit, before the body is read.

        Everybody in the room has a bucket of their own, which no neighbour can empty.
        """
        visitor = request[_VISITOR]
        if visitor.is_host:
            return
        now_s = self._clock.now_s()
        if self._room.role_of(visitor) != "stranger" and self._own.take(visitor.identity, now_s):
            return
        if not buckets.take(visitor.address, now_s):
            raise TooOftenError(Sentence("door.too_often"), retry_after_s=self._again_s)

    @contextmanager
    def _limiting_failures(self, request: web.Request) -> Iterator[None]:
        """Limit failed tries only: the right secret works, whatever neighbours try."""
        try:
            yield
        except ForbiddenError:
            if not self._failures.take(self._guards.sender(request), self._clock.now_s()):
                raise TooOftenError(Sentence("door.too_many_tries")) from None
            raise

    def _warn_of_plain_http(self, request: web.Request) -> None:
        seen = self._guards.seen(request)
        if seen.scheme == "https" or is_loopback(seen.sender) or seen.sender in self._warned:
            return
        if len(self._warned) < _MAX_ADDRESSES:
            self._warned.add(seen.sender)
        _LOG.warning(
            "the host's page is open without HTTPS: whoever can read the network can become host;"
            " start with --https",
            sender=seen.sender,
        )


def _json(answer: BaseModel, status: int = 200) -> web.Response:
    text = answer.model_dump_json()
    return web.Response(text=text, status=status, content_type="application/json")


async def _body(request: web.Request, model: type[_Body]) -> _Body:
    """Return the JSON body; raises `ProtocolError`."""
    most = model.most_bytes
    data = bytearray()
    while piece := await request.content.readany():
        data += piece
        if len(data) > most:
            raise web.HTTPRequestEntityTooLarge(most, len(data))
    is_packed = request.headers.get("Content-Encoding", "").lower() == "gzip"
    return parsed(bytes(data), model, is_packed=is_packed)


def parsed(data: bytes, model: type[_Body], *, is_packed: bool) -> _Body:
    """Return a complete body as its model; raises `ProtocolError`."""
    data = _unpacked(data, model.most_bytes) if is_packed else data
    return foreign_json.read(data, model.most_bytes, model.model_validate_json)


def _unpacked(data: bytes, most: int) -> bytes:
    """Return a gzip body unpacked; it may be no longer than one sent without gzip."""
    unpacking = zlib.decompressobj(wbits=zlib.MAX_WBITS | _GZIP)
    try:
        unpacked = unpacking.decompress(data, most)
    except zlib.error as error:
        raise ProtocolError("the body is no gzip") from error
    if not unpacking.eof:
        if len(unpacked) < most:
            raise ProtocolError("the body: it is cut off")
        raise web.HTTPRequestEntityTooLarge(most, len(unpacked))
    return unpacked


@web.middleware
async def _tell_errors(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Turn every error into a sentence."""
    try:
        return await handler(request)
    except NotAdmittedError as error:
        openings = [one.model_dump() for one in error.openings]
        more = {"ended": True, "openings": openings}
        return _refuse(request, HTTP_STATUS[NotAdmittedError], error.sentence, more)
    except NotForUsError as error:
        return _refuse(request, error.status, error.sentence)
    except WaxError as error:
        refusal = _refuse(request, HTTP_STATUS.get(type(error), 500), error.sentence)
        if isinstance(error, (FullError, TooOftenError)):
            refusal.headers["Retry-After"] = str(error.retry_after_s)
        return refusal
    except web.HTTPException as error:
        if error.status < 400:
            raise
        error.with_traceback(None)  # the request holds the error of an unknown path
        return _refuse(request, error.status, says(error.reason))
    except Exception:
        _LOG.exception("request failed", path=request.path)
        return _refuse(request, 500, Sentence("request.failed"))


def _refuse(
    request: web.Request,
    status: int,
    sentence: Sentence,
    more: Mapping[str, object] | None = None,
) -> web.Response:
    """Return the reason, in English: as a page for a browser's user, else as JSON with its code."""
    if "text/html" in request.headers.get("Accept", ""):
        text = (
            '<!doctype html><html lang="en"><meta name="viewport" content="width=device-width">'
            f"<title>WAX</title><p>{escape(str(sentence))}</p></html>"
        )
        return web.Response(status=status, text=text, content_type="text/html")
    body = {"error": str(sentence), "sentence": sentence.wire(), **(more or {})}
    return web.json_response(body, status=status)
