"""All rooms at media servers: publishes into each, counts its viewers, sends them news."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Final

import aiohttp
import structlog

from wax.cluster.errors import RoomError
from wax.cluster.leaving import Leaving
from wax.cluster.livekit import LiveKitRoom
from wax.cluster.publication import Publication
from wax.cluster.room_directory import Occupancy, choose
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

_BROADCAST_S: Final = 1.0
_COUNT_S: Final = 5.0
_POLL_S: Final = 0.1
_RETRY_S: Final = 2.0
_AGAIN_S: Final = (5.0, 30.0, 120.0, 300.0, 660.0)
"""When a removal is repeated: LiveKit readmits a removed viewer by their token, and renews it for
ten minutes while they are connected."""


@dataclass(frozen=True, slots=True)
class RoomSeat:
    """A place in a LiveKit room: its name, LiveKit's address, and a token."""

    room: str
    url: str
    token: str


@dataclass(frozen=True, slots=True)
class _Published:
    """A room with its publications; `livekit` is None at another media server."""

    occupancy: Occupancy
    livekit: LiveKitRoom | None
    publications: Sequence[Publication]
    watch: str
    leaving: Leaving = field(default_factory=Leaving)

    @property
    def is_live(self) -> bool:
        return all(told.problem is None for told in self.publications)


@dataclass(frozen=True, slots=True)
class PublishedSources:
    """The hubs whose streams are published; to them, a room is one more viewer.

    `audio` is None where not everybody may hear: a room cannot withhold it from anyone.
    """

    codecs: Codecs
    video: VideoHub
    audio: SoundHub | None


class Cluster:
    """The rooms of `[[publish]]`, idle if there are none."""

    def __init__(self, *, clock: Clock, counters: Counters) -> None:
        self._clock = clock
        self._counters = counters
        self._http: aiohttp.ClientSession | None = None
        self._rooms: list[_Published] = []
        self._news: Callable[[], str | None] = _nothing

    def publish(
        self,
        settings: Sequence[PublishSettings],
        renditions: Sequence[str],
        sources: PublishedSources,
    ) -> None:
        """Set the rooms for `run`; raises `StartError` for a secret that cannot be read.

        `renditions` are the names of those published, the best first; a room that is not LiveKit's
        gets only the first, since its page cannot choose.
        """
        self._rooms = [self._room(one, renditions, sources) for one in settings]

    def broadcast(self, news: Callable[[], str | None]) -> None:
        """Send everybody what `news` returns, once a second; nothing if that is None."""
        self._news = news

    # --- for admission ---------------------------------------------------------------------

    def seats(self, person: str, before: Sequence[str] = ()) -> list[RoomSeat]:
        """Return this person's seats, the one to use first; empty if all rooms are full.

        `before` are the rooms that they already have seats in, which they keep.
        """
        by_name = {one.occupancy.name: one.livekit for one in self._rooms}
        mine = [one for one in self._rooms if one.livekit is not None]
        for one in mine:
            one.leaving.cancel(person)
        return [
            RoomSeat(one.name, livekit.url, livekit.watch_token(person))
            for one in choose([one.occupancy for one in mine if one.is_live], before)
            if (livekit := by_name[one.name]) is not None
        ]

    @property
    def is_used(self) -> bool:
        """Whether there is any room, whatever its state."""
        return bool(self._rooms)

    @property
    def lost(self) -> list[int]:
        """The numbers, from 1, of the rooms that get no picture now."""
        return [number for number, one in enumerate(self._rooms, 1) if not one.is_live]

    @property
    def capacity(self) -> int:
        """The maximum of viewers of all LiveKit rooms together."""
        return sum(one.occupancy.most for one in self._rooms if one.livekit is not None)

    @property
    def has_sound(self) -> bool:
        """Whether any room carries sound."""
        return any(told.has_sound for one in self._rooms for told in one.publications)

    @property
    def links(self) -> list[str]:
        """The public pages of live rooms at other media servers."""
        return [one.watch for one in self._rooms if one.watch and one.is_live]

    @property
    def watching(self) -> int:
        """How many watch in the rooms, by the newest count."""
        return sum(one.occupancy.counted for one in self._rooms)

    def remove(self, person: str, *, for_good: bool = False) -> None:
        """Remove somebody from every room, if they are there.

        `for_good` repeats that until they get a seat again, since their token outlives a removal.
        """
        now_s = self._clock.now_s()
        after_s = (0.0, *_AGAIN_S) if for_good else (0.0,)
        for room in self._rooms:
            if room.livekit is not None:
                room.leaving.add(person, (now_s + one for one in after_s))

    def status(self) -> list[dict[str, object]]:
        """Return an entry for each room for the host's status page."""
        return [
            {
                "name": one.occupancy.name,
                "is_live": one.is_live,
                "watching": one.occupancy.counted,
                "max_viewers": one.occupancy.most,
                "publications": {told.rendition: told.problem for told in one.publications},
            }
            for one in self._rooms
        ]

    # --- what runs -------------------------------------------------------------------------

    async def run(self) -> None:
        """Serve every room until cancelled; no failure ends it: driving does not depend on it."""
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
        # A redirect's address is used byte for byte, too: it may be signed.
        as_told = aiohttp.ClientSession(requote_redirect_url=False)
        async with as_told as self._http, asyncio.TaskGroup() as together:
            for one in self._rooms:
                for publication in one.publications:
                    together.create_task(publication.run(), name=f"publish {publication.name}")
                if one.livekit is not None:
                    # A task for each: a room that does not answer delays no other.
                    for what in (self._broadcast, self._count, self._remove):
                        together.create_task(what(one.livekit, one), name=f"tend {what.__name__}")

    async def _broadcast(self, livekit: LiveKitRoom, room: _Published) -> None:
        while True:
            await asyncio.sleep(_BROADCAST_S)
            try:
                text = self._news() if room.is_live else None
            except Exception:  # the picture must go on
                self._counters.add("room messages failed")
                _LOG.exception("there is no news for the rooms")
                continue
            if text is not None:
                try:
                    await livekit.send(text)
                except RoomError:
                    self._counters.add("room messages lost")

    async def _count(self, livekit: LiveKitRoom, room: _Published) -> None:
        while True:
            try:
                people = await livekit.count()
            except RoomError:
                self._counters.add("rooms not counted")
            else:
                room.occupancy.count(max(people - len(room.publications), 0))
            await asyncio.sleep(_COUNT_S)

    async def _remove(self, livekit: LiveKitRoom, room: _Published) -> None:
        """Remove people one by one: a crowd that leaves at once must not cause a burst of calls."""
        while True:
            await asyncio.sleep(_POLL_S)
            while (person := room.leaving.due(self._clock.now_s())) is not None:
                try:
                    await livekit.remove(person)
                except RoomError:
                    self._counters.add("people not removed")

    # --- making ----------------------------------------------------------------------------

    def _room(
        self, settings: PublishSettings, renditions: Sequence[str], sources: PublishedSources
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
                # The smaller rendition carries the sound: the thinnest uplink still carries that.
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
        """Return a new session; raises `RoomError`."""
        if livekit is None:
            return WhipSession(
                http=self._session, url=settings.whip, token=lambda: settings.whip_token
            )
        # Each time: LiveKit deletes an empty room, and WHIP would create one with defaults.
        await livekit.create()
        return WhipSession(
            http=self._session,
            url=livekit.whip_url,
            token=lambda: livekit.publish_token(f"robot {rendition}"),
        )

    def _session(self) -> aiohttp.ClientSession:
        assert self._http is not None, "run() comes first"
        return self._http


def _nothing() -> None: ...
