"""The HTTP routes."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeVar

import structlog
from aiohttp import web
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from wax.errors import (
    HTTP_STATUS,
    ForbiddenError,
    ProtocolError,
    StartError,
    TooOftenError,
    WaxError,
)
from wax.rtc.signalling import MAX_SDP_CHARS
from wax.session.token_bucket import TokenBuckets
from wax.web.addresses import is_from_here
from wax.web.security_headers import policy_of_document

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from wax.clock import Clock
    from wax.rtc.ice_servers import IceServers
    from wax.session.proof_runner import ProofRunner
    from wax.session.room import Room
    from wax.web.guards import Guards

    Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

_LOG = structlog.get_logger(__name__)

MAX_BODY_BYTES: Final = 65_536

_OFFERS_HZ: Final = 2.0
_OFFERS_BURST: Final = 40
"""Per address: a class behind one router connects at once, and each answer takes 10 ms of CPU."""
_MAX_ADDRESSES: Final = 1024

PAGE: Final = Path(__file__).parent / "dist"

Client = Annotated[str, Field(pattern=r"^[A-Za-z0-9-]{8,64}$")]
"""The secret that identifies a page when it reconnects."""

_Body = TypeVar("_Body", bound=BaseModel)


class Offer(BaseModel):
    """A page's session description, and the secret that identifies it when it reconnects."""

    model_config = ConfigDict(extra="forbid", strict=True)

    sdp: Annotated[str, Field(min_length=1, max_length=MAX_SDP_CHARS)]
    client: Client


class StopPress(BaseModel):
    """The viewer who presses Stop, if the request names one."""

    model_config = ConfigDict(extra="forbid", strict=True)

    client: Client | None = None


class StopRelease(BaseModel):
    """Which stop to release, and who asks."""

    model_config = ConfigDict(extra="forbid", strict=True)

    client: Client | None = None
    stop: Annotated[int, Field(ge=0)]


class Lifted(BaseModel):
    """The host's confirmation that the wheels are off the floor."""

    model_config = ConfigDict(extra="forbid", strict=True)

    lifted: Literal[True]


class Routes:
    """Answers HTTP; `status` makes the JSON of the status page."""

    def __init__(
        self,
        *,
        room: Room,
        clock: Clock,
        ice: IceServers,
        status: Callable[[], dict[str, object]],
        proving: ProofRunner,
        acknowledged: bool,
        guards: Guards,
    ) -> None:
        self._guards = guards
        self._room = room
        self._clock = clock
        self._offers = TokenBuckets(rate_hz=_OFFERS_HZ, burst=_OFFERS_BURST, most=_MAX_ADDRESSES)
        self._proof_runner = proving
        self._ice = ice
        self._status = status
        self._acknowledged = acknowledged

    def application(self) -> web.Application:
        """Make the application; raises `StartError` if the page was not built."""
        if not (PAGE / "index.html").is_file():
            raise StartError("the page is not built; run `make run`, or `pip install .` again")
        application = web.Application(
            client_max_size=MAX_BODY_BYTES, middlewares=[_tell_errors, *self._guards.middlewares]
        )
        application.on_response_prepare.append(self._guards.add_headers)
        application.add_routes(
            [
                web.get("/", self.page),
                web.get("/healthz", self.health),
                web.get("/api/status", self.status),
                web.get("/api/ice", self.ice),
                web.post("/api/offer", self.offer),
                web.post("/api/stop", self.stop),
                web.post("/api/release", self.release),
                web.post("/api/proof", self.prove),
                web.get("/api/proof", self.proof),
                web.get("/api/proof/record", self.record),
                web.static("/", PAGE),
            ]
        )
        return application

    async def page(self, request: web.Request) -> web.StreamResponse:  # noqa: ARG002  # aiohttp's form
        # The assets have a hash in their names; the page itself must be revalidated each time.
        headers = {"Cache-Control": "no-cache"}
        if not self._acknowledged:
            return web.FileResponse(PAGE / "index.html", headers=headers)
        # The page must know before it connects: later it would have to connect again.
        text = (PAGE / "index.html").read_text(encoding="utf-8")
        text = text.replace("<html ", "<html data-acknowledge ", 1)
        answer = web.Response(text=text, content_type="text/html", headers=headers)
        answer.enable_compression()
        return answer

    async def health(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return web.json_response({"ok": True})

    async def status(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return web.json_response(self._status())

    async def ice(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        told = self._ice.page(secrets.token_hex(4), self._clock.wall_ms() / 1000)
        return web.json_response(told)

    async def offer(self, request: web.Request) -> web.Response:
        # Before the body is read. Users of this machine could stop the robot in other ways anyway.
        is_host = is_from_here(request)
        address = self._guards.sender(request)
        if not is_host and not self._offers.take(address, self._clock.now_s()):
            raise TooOftenError(
                "Too many connections from your address; wait a few seconds and try again."
            )
        offer = await _body(request, Offer)
        answer = await self._room.answer(offer.client, offer.sdp, is_host=is_host, address=address)
        return web.json_response({"sdp": answer})

    async def stop(self, request: web.Request) -> web.Response:
        press = await _body(request, StopPress)
        number = self._room.stop_by(press.client, is_host=is_from_here(request))
        return web.json_response({"stop": number})

    async def release(self, request: web.Request) -> web.Response:
        release = await _body(request, StopRelease)
        self._room.release_by(release.client, release.stop, is_host=is_from_here(request))
        return web.json_response({"ok": True})

    async def prove(self, request: web.Request) -> web.Response:
        _only_here(request)
        await _body(request, Lifted)
        await self._proof_runner.start()
        return web.json_response(self._proof_runner.progress(), status=202)

    async def proof(self, request: web.Request) -> web.Response:
        _only_here(request)
        return web.json_response(self._proof_runner.progress())

    async def record(self, request: web.Request) -> web.Response:
        _only_here(request)
        text = self._proof_runner.record()
        headers = {"Content-Security-Policy": policy_of_document(text)}
        return web.Response(text=text, content_type="text/html", headers=headers)


async def _body(request: web.Request, model: type[_Body]) -> _Body:
    """Return the JSON body; raises `ProtocolError`."""
    try:
        return model.model_validate_json(await request.read())
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the body"
        raise ProtocolError(f"{where}: {first['msg']}") from error


def _only_here(request: web.Request) -> None:
    if not is_from_here(request):
        raise ForbiddenError("Only a page on the server's own machine can do that.")


@web.middleware
async def _tell_errors(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Turn every error into JSON with a sentence."""
    try:
        return await handler(request)
    except WaxError as error:
        return _refuse(HTTP_STATUS.get(type(error), 500), str(error))
    except web.HTTPException as error:
        if error.status < 400:
            raise
        return _refuse(error.status, error.reason)
    except Exception:
        _LOG.exception("request failed", path=request.path)
        return _refuse(500, "the server failed to handle this request; see its log")


def _refuse(status: int, sentence: str) -> web.Response:
    return web.json_response({"error": sentence}, status=status)
