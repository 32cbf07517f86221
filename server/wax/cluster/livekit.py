"""LiveKit's server API, and the tokens that admit people to a room.

The API is Twirp, a POST of JSON for each call (docs.livekit.io, "Room service API"), so the HTTP
client that we already have is enough.
"""

from __future__ import annotations

import base64
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import aiohttp
import jwt
from pydantic import BaseModel, Field

from wax.as_written import as_written
from wax.cluster.bounded_answer import read_body
from wax.cluster.errors import RoomError, not_reached
from wax.errors import ProtocolError
from wax.protocol import foreign_json

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping

_LIMIT_S: Final = 3.0
_TIMEOUT: Final = aiohttp.ClientTimeout(total=_LIMIT_S)
_SERVICE_TOKEN_S: Final = 60
_PUBLISH_TOKEN_S: Final = 60
"""Long enough for WHIP's one request; a session outlives its token."""
WATCH_TOKEN_S: Final = 300
"""Pages renew it earlier; while they are connected, LiveKit renews it for ten minutes anyway."""
_CLOCKS_APART_S: Final = 30
_PLAYOUT_DELAY_MS: Final = 200
"""The most that a browser holds pictures back, whatever the page asks for while the sound is late;
LiveKit by itself would ask for ten times the link's jitter."""
_EMPTY_S: Final = 300
TOPIC: Final = "wax"
_MAX_ANSWER_BYTES: Final = 16_384
"""Enough for one room with all its codecs and metadata."""
_MOST_MARKS: Final = 2048


class _Room(BaseModel):
    num_participants: int = 0


class _Answer(BaseModel):
    """The parts of any answer that we use: a reason, or the rooms."""

    msg: str = ""
    rooms: Annotated[list[_Room], Field(max_length=1)] = []


class LiveKitRoom:
    """One room; `url` is LiveKit's address for pages (``wss://…``).

    Every call raises `RoomError` if LiveKit fails or refuses.
    """

    def __init__(
        self,
        *,
        http: Callable[[], aiohttp.ClientSession],
        url: str,
        name: str,
        api_key: str,
        api_secret: str,
        wall_s: Callable[[], float],
    ) -> None:
        self.url = url
        self.name = name
        self._http = http
        self._key = api_key
        self._secret = api_secret
        self._wall_s = wall_s

    @property
    def whip_url(self) -> str:
        """The address to publish at (RFC 9725)."""
        return f"{self._api}/whip/v1"

    def publish_token(self, identity: str) -> str:
        """Return a token that lets the robot publish under this name, and do nothing else."""
        return self._signed(identity, _PUBLISH_TOKEN_S, canPublish=True, canSubscribe=False)

    def watch_token(self, identity: str) -> str:
        """Return a token that lets one person watch, unseen by the others in the room."""
        return self._signed(
            identity, WATCH_TOKEN_S, canPublish=False, canSubscribe=True, hidden=True
        )

    async def create(self) -> None:
        """Create the room if it is missing, with sound and picture synchronized."""
        await self._check_ready()
        await self._call(
            "CreateRoom",
            {
                "name": self.name,
                "empty_timeout": _EMPTY_S,
                "sync_streams": True,
                "max_playout_delay": _PLAYOUT_DELAY_MS,
            },
        )

    async def count(self) -> int:
        """Return how many are in the room, 0 if there is none."""
        told = await self._call("ListRooms", {"names": [self.name]})
        return sum(one.num_participants for one in told.rooms)

    async def send(self, text: str) -> None:
        """Send a text to everybody in the room, by the API rather than as a participant."""
        data = base64.b64encode(text.encode()).decode()
        await self._call(
            "SendData", {"room": self.name, "data": data, "kind": "RELIABLE", "topic": TOPIC}
        )

    async def remove(self, identity: str) -> None:
        """Remove one person from the room."""
        await self._call("RemoveParticipant", {"room": self.name, "identity": identity})

    async def _check_ready(self) -> None:
        """Raise `RoomError` if its cluster takes this node for dead, as just after it has hung.

        Asked for the room then, it would assign it to another node, and a page that loses that node
        would lose both.
        """
        async with self._request("GET", "/") as response:
            if response.status == HTTPStatus.NOT_ACCEPTABLE:
                raise RoomError(f"{self.url} is not ready yet")

    @property
    def _api(self) -> str:
        return self.url.replace("ws", "http", 1)

    def _signed(self, subject: str, lasts_s: int, **grants: bool | str) -> str:
        now_s = int(self._wall_s())
        claims = {
            "iss": self._key,
            "sub": subject,
            "nbf": now_s - _CLOCKS_APART_S,
            "exp": now_s + lasts_s,
            "video": {"room": self.name, "roomJoin": True, "canPublishData": False, **grants},
        }
        return jwt.encode(claims, self._secret, algorithm="HS256")

    async def _call(
        self,
        what: Literal["CreateRoom", "ListRooms", "SendData", "RemoveParticipant"],
        body: Mapping[str, Any],
    ) -> _Answer:
        token = self._signed(
            "wax", _SERVICE_TOKEN_S, roomCreate=True, roomList=True, roomAdmin=True
        )
        async with self._request(
            "POST",
            f"/twirp/livekit.RoomService/{what}",
            json=body,
            headers={"Authorization": f"Bearer {token}"},
        ) as response:
            text = await read_body(response, _MAX_ANSWER_BYTES)
        try:
            told = foreign_json.read(
                text, _MAX_ANSWER_BYTES, _Answer.model_validate_json, most_marks=_MOST_MARKS
            )
        except ProtocolError as error:
            raise RoomError(
                f"{self.url} does not answer {what} as LiveKit does ({response.status}): {error}"
            ) from error
        if response.status != HTTPStatus.OK:
            why = told.msg or response.reason
            raise RoomError(f"{self.url} refuses {what}: {why}; check its key, secret and name")
        return told

    @asynccontextmanager
    async def _request(
        self, method: str, path: str, **more: Any
    ) -> AsyncIterator[aiohttp.ClientResponse]:
        """Yield the response, to read inside the block; raises `RoomError` if there is none."""
        try:
            async with self._http().request(
                method, as_written(self._api + path), timeout=_TIMEOUT, **more
            ) as response:
                yield response
        except (aiohttp.ClientError, TimeoutError, ValueError) as error:
            raise await not_reached(self.url, error, _LIMIT_S) from error
