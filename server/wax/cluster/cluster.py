"""All rooms: publishes into each, counts who is there, tells them of the robot's room."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
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
    from wax.config.settings import PublishSettings, VideoSettings
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


class Cluster:
    """The rooms of `[[publish]]`; without any, nothing here does anything."""

    def __init__(
        self,
        *,
        settings: Sequence[PublishSettings],
        ladder: VideoSettings,
        codecs: Codecs,
        video: VideoHub,
        audio: SoundHub,
        clock: Clock,
        counters: Counters,
    ) -> None:
        self._clock = clock
        self._codecs = codecs
        self._video = video
        self._audio = audio
        self._counters = counters
        self._names = rooms.renditions(ladder.renditions)
        self._http: aiohttp.ClientSession | None = None
        self._rooms = [self._room(one) for one in settings]
        self._text: str | None = None

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
                _TASKS.add(task)
                task.add_done_callback(_TASKS.discard)

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
        """Keep every room going until cancelled."""
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

    def _room(self, settings: PublishSettings) -> _Published:
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
        return _Published(
            Occupancy(settings.name, settings.max_viewers),
            livekit,
            [self._publication(settings, livekit, name) for name in self._published(settings)],
            settings.watch,
        )

    def _published(self, settings: PublishSettings) -> Sequence[str]:
        """Return the renditions of a room: two where a page can choose, else the best."""
        return self._names if settings.livekit else self._names[:1]

    def _publication(
        self, settings: PublishSettings, livekit: LiveKitRoom | None, rendition: str
    ) -> Publication:
        """Publish a rendition; the sound goes with the last, which the thinnest uplink carries."""

        def session() -> WhipSession:
            if livekit is None:
                token = settings.whip_token
                return WhipSession(http=self._session, url=settings.whip, token=lambda: token)
            return WhipSession(
                http=self._session,
                url=livekit.whip_url,
                token=lambda: livekit.publish_token(f"robot {rendition}"),
            )

        return Publication(
            name=settings.name,
            rendition=rendition,
            with_sound=rendition == self._published(settings)[-1],
            codecs=self._codecs,
            video=self._video,
            audio=self._audio,
            clock=self._clock,
            counters=self._counters,
            session=session,
        )

    def _session(self) -> aiohttp.ClientSession:
        assert self._http is not None, "run() comes first"
        return self._http


_TASKS: Final[set[asyncio.Task[None]]] = set()
