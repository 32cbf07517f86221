"""LiveKit's server API, and the tokens by which people get into a room.

Its services are Twirp: a POST of JSON each (docs.livekit.io, "Room service API"), for which the
HTTP client that is here anyway is enough.
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
from wax.cluster.bounded_answer import whole
from wax.cluster.errors import RoomError, not_reached
from wax.errors import ProtocolError
from wax.protocol import foreign_json

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping

_LIMIT_S: Final = 3.0
_TIMEOUT: Final = aiohttp.ClientTimeout(total=_LIMIT_S)
_SERVICE_TOKEN_S: Final = 60
_PUBLISH_TOKEN_S: Final = 60
"""For the one request of WHIP; a session outlives its token."""
WATCH_TOKEN_S: Final = 300
"""Pages ask for another before; LiveKit gives whoever is connected one of ten minutes anyway."""
_CLOCKS_APART_S: Final = 30
_PLAYOUT_DELAY_MS: Final = 200
"""The most that a browser holds pictures back: whatever the page asks for while the sound is late,
and whatever LiveKit does, which asks for ten times the link's jitter."""
_EMPTY_S: Final = 300
TOPIC: Final = "wax"
_MAX_ANSWER_BYTES: Final = 16_384
"""About one room, with all its codecs and metadata."""
_MOST_MARKS: Final = 2048


class _Room(BaseModel):
    num_participants: int = 0


class _Answer(BaseModel):
    """What counts of any of its answers: its reason, or the rooms."""

    msg: str = ""
    rooms: Annotated[list[_Room], Field(max_length=1)] = []


class LiveKitRoom:
    """One room; `url` is LiveKit's address as pages use it (``wss://…``).

    Every call raises `RoomError` where LiveKit does not do what it is asked.
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
        """Where the robot publishes (RFC 9725)."""
        return f"{self._api}/whip/v1"

    def publish_token(self, identity: str) -> str:
        """Let the robot publish under this name, and do nothing else."""
        return self._signed(identity, _PUBLISH_TOKEN_S, canPublish=True, canSubscribe=False)

    def watch_token(self, identity: str) -> str:
        """Let one person watch, whom nobody else in the room sees."""
        return self._signed(
            identity, WATCH_TOKEN_S, canPublish=False, canSubscribe=True, hidden=True
        )

    async def create(self) -> None:
        """Make the room if there is none, so that sound and picture have one clock."""
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

    async def tell(self, text: str) -> None:
        """Send a text to everybody in the room, without being in it."""
        data = base64.b64encode(text.encode()).decode()
        await self._call(
            "SendData", {"room": self.name, "data": data, "kind": "RELIABLE", "topic": TOPIC}
        )

    async def remove(self, identity: str) -> None:
        """Take one person out of the room; without a new token they do not come back."""
        await self._call("RemoveParticipant", {"room": self.name, "identity": identity})

    async def _check_ready(self) -> None:
        """Raise where the node counts as dead in its cluster, as one does that has just hung.

        Asked for its room then, it gives the room to another node, and who loses that one loses
        both.
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
            text = await whole(response, _MAX_ANSWER_BYTES)
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
        """Have the response inside the block, which may read it; raises `RoomError` without one."""
        try:
            async with self._http().request(
                method, as_written(self._api + path), timeout=_TIMEOUT, **more
            ) as response:
                yield response
        except (aiohttp.ClientError, TimeoutError, ValueError) as error:
            raise await not_reached(self.url, error, _LIMIT_S) from error
