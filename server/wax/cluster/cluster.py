"""All rooms: publishes into each, counts who is there, tells them of the robot's room."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from functools import partial
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
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.config.publish import PublishSettings
    from wax.fanout.sound_hub import SoundHub
    from wax.fanout.video_hub import VideoHub
    from wax.streams.interface import Codecs
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_TELL_S: Final = 1.0
_COUNT_S: Final = 5.0
_RETRY_S: Final = 2.0


@dataclass(frozen=True, slots=True)
class Seat:
    """Where somebody may watch: LiveKit's address and a token for it."""

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
    """What is published: the hubs, of which the rooms are one more viewer each."""

    codecs: Codecs
    video: VideoHub
    audio: SoundHub


class Cluster:
    """The rooms of `[[publish]]`; without any, nothing here does anything."""

    def __init__(self, *, clock: Clock, counters: Counters) -> None:
        self._clock = clock
        self._counters = counters
        self._http: aiohttp.ClientSession | None = None
        self._rooms: list[_Published] = []
        self._text: str | None = None
        self._removing: set[asyncio.Task[None]] = set()

    def publish(
        self, settings: Sequence[PublishSettings], renditions: Sequence[str], sources: Sources
    ) -> None:
        """Publish into these rooms once `run` begins; raises `StartError` for an unread secret.

        `renditions` are the names of what a room gets, the best first; where a page cannot choose,
        only that.
        """
        self._rooms = [self._room(one, renditions, sources) for one in settings]

    # --- for whoever admits viewers --------------------------------------------------------

    def seats(self, person: str) -> list[Seat]:
        """Return where this person may watch, the first for now; empty where all is full."""
        by_name = {one.occupancy.name: one.livekit for one in self._rooms}
        found = rooms.choose(one.occupancy for one in self._rooms if one.livekit is not None)
        return [
            Seat(livekit.url, livekit.watch_token(person))
            for one in found
            if (livekit := by_name[one.name]) is not None
        ]

    @property
    def is_used(self) -> bool:
        """Whether there is a room whose viewers are told anything."""
        return any(one.livekit is not None for one in self._rooms)

    @property
    def links(self) -> list[str]:
        """Pages elsewhere on which anybody may watch, of rooms that are not LiveKit's."""
        return [one.watch for one in self._rooms if one.watch and one.occupancy.is_live]

    @property
    def watching(self) -> int:
        """How many watch there, by the newest count."""
        return sum(one.occupancy.counted for one in self._rooms)

    def remove(self, person: str) -> None:
        """Take somebody out of every room; whoever is gone already is none to complain of."""
        for one in self._rooms:
            if one.livekit is not None:
                task = asyncio.create_task(self._removed(one.livekit, person), name="remove")
                self._removing.add(task)
                task.add_done_callback(self._removing.discard)

    def tell(self, text: str) -> None:
        """Tell everybody this, within a second; what they were not told before is left out."""
        self._text = text

    def status(self) -> list[dict[str, object]]:
        """Return each room as the host's status page has it."""
        return [
            {
                "name": one.occupancy.name,
                "watching": one.occupancy.counted,
                "problems": [told.problem for told in one.publications if told.problem],
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
                together.create_task(self._keep(one), name=f"room {one.occupancy.name}")
            together.create_task(self._tell_all(), name="tell the rooms")
            together.create_task(self._count_all(), name="count the rooms")

    async def _keep(self, room: _Published) -> None:
        """Make the room, then publish into it."""
        while room.livekit is not None:
            try:
                await room.livekit.create()
                break
            except RoomError as error:
                _LOG.warning("no room", room=room.occupancy.name, why=str(error))
                await asyncio.sleep(_RETRY_S)
        async with asyncio.TaskGroup() as together:
            for one in room.publications:
                together.create_task(one.run(), name=f"publish {one.name}")

    async def _tell_all(self) -> None:
        while True:
            await asyncio.sleep(_TELL_S)
            text, self._text = self._text, None
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
            room.occupancy.counted = max(await room.livekit.count() - len(room.publications), 0)
            room.occupancy.sent = 0
        except RoomError:
            self._counters.add("rooms not counted")

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
                with_sound=rendition == chosen[-1],
                codecs=sources.codecs,
                video=sources.video,
                audio=sources.audio,
                clock=self._clock,
                counters=self._counters,
                session=partial(self._whip, settings, livekit, rendition),
            )
            for rendition in chosen
        ]
        occupancy = Occupancy(settings.name, settings.max_viewers)
        return _Published(occupancy, livekit, publications, settings.watch)

    def _whip(
        self, settings: PublishSettings, livekit: LiveKitRoom | None, rendition: str
    ) -> WhipSession:
        if livekit is None:
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
