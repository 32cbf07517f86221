"""Publishes one rendition, perhaps with the sound, into a room, and reconnects when it ends."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import structlog

from wax.cluster.errors import RoomError
from wax.cluster.silence import Silence
from wax.congestion.allocation import SoundEncoding
from wax.error_boundary import ErrorBoundary
from wax.errors import SignallingError
from wax.rtc.publisher import Publisher

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from wax.clock import Clock
    from wax.cluster.whip import WhipSession
    from wax.fanout.sound_hub import SoundHub
    from wax.fanout.video_hub import VideoHub
    from wax.fanout.video_lane import VideoLane
    from wax.streams.interface import Codecs
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_CONNECT_S: Final = 8.0
_POLL_S: Final = 0.15
_FIRST_RETRY_S: Final = 0.5
_LAST_RETRY_S: Final = 2.0
"""Short, so that a server that is back is used again within five seconds."""
_KEYFRAMES_APART_S: Final = 1.0
"""A keyframe costs every viewer bandwidth, people join all the time, and LiveKit asks until one
arrives."""
_SOUND: Final = SoundEncoding(20, 32_000)


class Publication:
    """`session` returns a new WHIP session for each connection, or raises `RoomError`.

    `rendition` is its name in the hub; `audio` is None where another publication has the sound.
    """

    def __init__(
        self,
        *,
        name: str,
        rendition: str,
        codecs: Codecs,
        video: VideoHub,
        audio: SoundHub | None,
        clock: Clock,
        counters: Counters,
        session: Callable[[], Awaitable[WhipSession]],
    ) -> None:
        self.name = name
        self.problem: str | None = "it has not begun"
        """Why nothing is published now; None while something is."""
        self.rendition = rendition
        self._codecs = codecs
        self._video = video
        self._audio = audio
        self._clock = clock
        self._counters = counters
        self._session = session
        self._is_logged = False
        self._keyframe_s = float("-inf")

    @property
    def has_sound(self) -> bool:
        """Whether this publication carries the sound."""
        return self._audio is not None

    async def run(self) -> None:
        """Publish until cancelled, and retry failures with a backoff."""
        retry_s = _FIRST_RETRY_S
        while True:
            try:
                await self._publish()
            except (RoomError, SignallingError, ConnectionError, TimeoutError) as error:
                self._note_failure(str(error) or "the connection takes too long")
            except Exception:
                _LOG.exception("a publication failed", room=self.name, rendition=self.rendition)
                self._note_failure("it failed; see the log")
            else:
                retry_s = _FIRST_RETRY_S
            await asyncio.sleep(retry_s)
            retry_s = min(2 * retry_s, _LAST_RETRY_S)

    async def _publish(self) -> None:
        """Publish until the connection ends; raises what `run` handles if it cannot connect."""
        session = await self._session()
        broken = asyncio.Event()
        boundary = ErrorBoundary(viewer=0, counters=self._counters, end=broken.set)
        picture = self._video.add(boundary)
        sound = None if self._audio is None else self._audio.add(boundary)
        publisher = Publisher(
            codecs=self._codecs,
            video=picture,
            audio=sound,
            clock=self._clock,
            on_keyframe_wanted=lambda: self._keyframe_wanted(picture),
        )
        try:
            async with asyncio.timeout(_CONNECT_S):
                await publisher.accept(await session.offer(await publisher.offer()))
                await publisher.connected()
            self._video.choose(picture, self.rendition)
            if self._audio is not None and sound is not None:
                self._audio.choose(sound, _SOUND, 0)
            self._note_success()
            await self._wait_until_ended(publisher, broken)
            # Before the session is ended, which waits for a frozen server.
            self._note_failure("the server has fallen silent")
        finally:
            self._video.remove(picture)
            if self._audio is not None and sound is not None:
                self._audio.remove(sound)
            await asyncio.shield(_close_both(session, publisher))

    async def _wait_until_ended(self, publisher: Publisher, broken: asyncio.Event) -> None:
        """Wait until the connection is closed or broken, or the server has fallen silent."""
        silence = Silence()
        while publisher.is_alive and not silence.is_certain(publisher.unheard_s):
            with suppress(TimeoutError):
                await asyncio.wait_for(broken.wait(), _POLL_S)
                return

    def _keyframe_wanted(self, picture: VideoLane) -> None:
        now_s = self._clock.now_s()
        if now_s - self._keyframe_s >= _KEYFRAMES_APART_S:
            self._keyframe_s = now_s
            self._video.request_keyframe(picture)

    def _note_success(self) -> None:
        _LOG.info("publishing", room=self.name, rendition=self.rendition)
        self.problem, self._is_logged = None, False

    def _note_failure(self, why: str) -> None:
        self._counters.add("publications failed")
        if not self._is_logged:
            _LOG.warning("not publishing", room=self.name, rendition=self.rendition, why=why)
        self.problem, self._is_logged = why, True


async def _close_both(session: WhipSession, publisher: Publisher) -> None:
    await asyncio.gather(session.end(), publisher.close())
