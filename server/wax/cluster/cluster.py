"""All rooms: publishes into each, counts who is there, tells them of the robot's room."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from functools import partial
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Final

import aiohttp
import structlog

from wax.cluster import rooms
from wax.cluster.errors import RoomError
from wax.cluster.livekit import LiveKitRoom
from wax.cluster.publication import Publication
from wax.cluster.rooms import Occupancy
from wax.cluster.whip import WhipSession

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.clock import Clock
    from wax.config.publish import PublishSettings
    from wax.fanout.sound_hub import SoundHub
    from wax.fanout.video_hub import VideoHub
    from wax.streams.interface import Codecs
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_TELL_S: Final = 1.0
_COUNT_S: Final = 5.0
_LOOK_S: Final = 0.1
_RETRY_S: Final = 2.0
_AGAIN_S: Final = (5.0, 30.0, 120.0, 300.0, 660.0)
"""LiveKit lets whoever was removed in again by the token that they have, and whoever is connected
has one of ten minutes."""


@dataclass(frozen=True, slots=True)
class Seat:
    """Where somebody may watch: a room, LiveKit's address, and a token for it."""

    room: str
    url: str
    token: str


@dataclass(frozen=True, slots=True)
class _Published:
    """A room with its publications; `livekit` is None where it is another's."""

    occupancy: Occupancy
    livekit: LiveKitRoom | None
    publications: Sequence[Publication]
    watch: str


@dataclass(frozen=True, slots=True)
class Sources:
    """What is published: the hubs, of which the rooms are one more viewer each.

    `audio` is None where not everybody may hear: nobody in a room can be kept from it.
    """

    codecs: Codecs
    video: VideoHub
    audio: SoundHub | None


class Cluster:
    """The rooms of `[[publish]]`; without any, nothing here does anything."""

    def __init__(self, *, clock: Clock, counters: Counters) -> None:
        self._clock = clock
        self._counters = counters
        self._http: aiohttp.ClientSession | None = None
        self._rooms: list[_Published] = []
        self._news: Callable[[], str | None] = _nothing
        self._leaving: list[tuple[float, str]] = []
        self._out: set[str] = set()

    def publish(
        self, settings: Sequence[PublishSettings], renditions: Sequence[str], sources: Sources
    ) -> None:
        """Publish into these rooms once `run` begins; raises `StartError` for an unread secret.

        `renditions` are the names of what a room gets, the best first; where a page cannot choose,
        only that.
        """
        self._rooms = [self._room(one, renditions, sources) for one in settings]

    def tell(self, news: Callable[[], str | None]) -> None:
        """Ask `news` once a second what all are to be told; None for nothing."""
        self._news = news

    # --- for whoever admits viewers --------------------------------------------------------

    def seats(self, person: str, before: Sequence[str] = ()) -> list[Seat]:
        """Return where this person may watch, the first for now; empty where all is full.

        `before` are the rooms that they were sent to already, in which they stay.
        """
        by_name = {one.occupancy.name: one.livekit for one in self._rooms}
        mine = (one.occupancy for one in self._rooms if one.livekit is not None)
        self._out.discard(person)
        return [
            Seat(one.name, livekit.url, livekit.watch_token(person))
            for one in rooms.choose(mine, before)
            if (livekit := by_name[one.name]) is not None
        ]

    @property
    def is_used(self) -> bool:
        """Whether there is any room, whatever its state."""
        return bool(self._rooms)

    @property
    def capacity(self) -> int:
        """How many may watch in LiveKit's rooms together."""
        return sum(one.occupancy.most for one in self._rooms if one.livekit is not None)

    @property
    def has_sound(self) -> bool:
        """Whether the rooms carry sound."""
        return any(told.has_sound for one in self._rooms for told in one.publications)

    @property
    def links(self) -> list[str]:
        """Pages elsewhere on which anybody may watch, of rooms that are not LiveKit's."""
        return [one.watch for one in self._rooms if one.watch and one.occupancy.is_live]

    @property
    def watching(self) -> int:
        """How many watch there, by the newest count."""
        return sum(one.occupancy.counted for one in self._rooms)

    def remove(self, person: str, *, for_good: bool = False) -> None:
        """Take somebody out of every room; whoever is gone already is none to complain of.

        `for_good` until they get a seat again: their token outlives the removal.
        """
        now_s = self._clock.now_s()
        self._out.add(person)
        for after_s in (0.0, *_AGAIN_S) if for_good else (0.0,):
            heappush(self._leaving, (now_s + after_s, person))

    def status(self) -> list[dict[str, object]]:
        """Return each room as the host's status page has it."""
        return [
            {
                "name": one.occupancy.name,
                "is_live": one.occupancy.is_live,
                "watching": one.occupancy.counted,
                "max_viewers": one.occupancy.most,
                "publications": {told.rendition: told.problem for told in one.publications},
            }
            for one in self._rooms
        ]

    # --- what runs -------------------------------------------------------------------------

    async def run(self) -> None:
        """Keep every room going until cancelled; never ends, since driving does not need it."""
        while True:
            try:
                await self._run()
            except Exception:
                self._counters.add("cluster faults")
                _LOG.exception("the rooms failed; they begin anew")
            await asyncio.sleep(_RETRY_S)

    async def _run(self) -> None:
        if not self._rooms:
            await asyncio.Event().wait()
        async with aiohttp.ClientSession() as self._http, asyncio.TaskGroup() as together:
            for one in self._rooms:
                for publication in one.publications:
                    together.create_task(publication.run(), name=f"publish {publication.name}")
            together.create_task(self._tell_all(), name="tell the rooms")
            together.create_task(self._count_all(), name="count the rooms")
            together.create_task(self._remove_all(), name="remove people")

    async def _tell_all(self) -> None:
        while True:
            await asyncio.sleep(_TELL_S)
            try:
                text = self._news()
            except Exception:  # the picture goes on
                self._counters.add("room messages failed")
                _LOG.exception("there is no news for the rooms")
                continue
            if text is not None:
                await asyncio.gather(*(self._told(one, text) for one in self._rooms))

    async def _told(self, room: _Published, text: str) -> None:
        if room.livekit is None or not room.occupancy.is_live:
            return
        try:
            await room.livekit.tell(text)
        except RoomError:
            self._counters.add("room messages lost")

    async def _count_all(self) -> None:
        looked_s = float("-inf")
        while True:
            for one in self._rooms:
                one.occupancy.is_live = all(told.problem is None for told in one.publications)
            if self._clock.now_s() - looked_s >= _COUNT_S:
                looked_s = self._clock.now_s()
                await asyncio.gather(*(self._count(one) for one in self._rooms))
            await asyncio.sleep(_TELL_S / 4)

    async def _count(self, room: _Published) -> None:
        if room.livekit is None:
            return
        try:
            people = await room.livekit.count()
        except RoomError:
            self._counters.add("rooms not counted")
        else:
            room.occupancy.count(max(people - len(room.publications), 0))

    async def _remove_all(self) -> None:
        """Remove one after the other: a crowd that leaves at once must not become one of calls."""
        while True:
            await asyncio.sleep(_LOOK_S)
            while self._leaving and self._leaving[0][0] <= self._clock.now_s():
                _, person = heappop(self._leaving)
                if person in self._out:
                    mine = [one.livekit for one in self._rooms if one.livekit is not None]
                    await asyncio.gather(*(self._removed(one, person) for one in mine))

    async def _removed(self, room: LiveKitRoom, person: str) -> None:
        try:
            await room.remove(person)
        except RoomError:
            self._counters.add("people not removed")

    # --- making ----------------------------------------------------------------------------

    def _room(
        self, settings: PublishSettings, renditions: Sequence[str], sources: Sources
    ) -> _Published:
        livekit = None
        if settings.livekit:
            livekit = LiveKitRoom(
                http=self._session,
                url=settings.livekit,
                name=settings.room,
                api_key=settings.api_key,
                api_secret=settings.secret(),
                wall_s=lambda: self._clock.wall_ms() / 1000,
            )
        chosen = renditions if livekit is not None else renditions[:1]
        publications = [
            Publication(
                name=settings.name,
                rendition=rendition,
                # With the smaller picture: the thinnest uplink carries that.
                audio=sources.audio if rendition == chosen[-1] else None,
                codecs=sources.codecs,
                video=sources.video,
                clock=self._clock,
                counters=self._counters,
                session=partial(self._session_for, settings, livekit, rendition),
            )
            for rendition in chosen
        ]
        occupancy = Occupancy(settings.name, settings.max_viewers)
        return _Published(occupancy, livekit, publications, settings.watch)

    async def _session_for(
        self, settings: PublishSettings, livekit: LiveKitRoom | None, rendition: str
    ) -> WhipSession:
        """Make a session; raises `RoomError`."""
        if livekit is not None:
            # Each time: a room that nobody was in is gone, and WHIP would make one by default.
            await livekit.create()
        else:
            return WhipSession(
                http=self._session, url=settings.whip, token=lambda: settings.whip_token
            )
        return WhipSession(
            http=self._session,
            url=livekit.whip_url,
            token=lambda: livekit.publish_token(f"robot {rendition}"),
        )

    def _session(self) -> aiohttp.ClientSession:
        assert self._http is not None, "run() comes first"
        return self._http


def _nothing() -> None: ...
