"""`audio-master` and `video-first`: each viewer's own policy, one encoder for everybody."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax import messages
from wax.streams.streams import Codecs, Kind, Units
from wax.sync.policies import make_policy

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from pydantic import BaseModel

    from wax.clock import Clock
    from wax.config import SyncSettings, VideoSettings
    from wax.media.lane import SoundLane, VideoLane
    from wax.media.sound_hub import SoundHub
    from wax.media.video_hub import VideoHub
    from wax.sync.playout import PlayoutReport, PlayoutTargets

_RETARGET_MS: Final = 4.0
"""A buffer is not retargeted for less: each change of the picture's is a small jump."""


class LiveStreams:
    """One viewer's lanes, and the targets of his page's two jitter buffers."""

    units: Units | None = None

    def __init__(
        self,
        *,
        clock: Clock,
        video: VideoHub,
        audio: SoundHub,
        send: Callable[[BaseModel], None],
        sync: SyncSettings,
    ) -> None:
        self._clock = clock
        self._video = video
        self._audio = audio
        self._send = send
        self._sync = sync
        self._policy = make_policy(sync)
        self._targets: PlayoutTargets | None = None
        self._sound_wanted = False
        self._is_ready = False
        self._video_lane: VideoLane | None = None
        self._sound_lane: SoundLane | None = None

    def lanes(self) -> tuple[VideoLane, SoundLane]:
        self.release()
        self._video_lane = self._video.add()
        self._sound_lane = self._audio.add()
        return self._video_lane, self._sound_lane

    def release(self) -> None:
        if self._video_lane is not None and self._sound_lane is not None:
            self._video.remove(self._video_lane)
            self._audio.remove(self._sound_lane)
        self._video_lane = self._sound_lane = None
        self._sound_wanted = False
        self._is_ready = False
        self._targets = None

    def connected(self) -> None:
        """Start the picture before the page can ask for it: it plays on load."""
        if self._video_lane is not None:
            self._video.choose(self._video_lane, self._video.sizes[0])

    def ready(self) -> None:
        self._is_ready = True
        self._retarget(self._policy.start())

    def want(self, *, sound: bool, picture: bool, size: str) -> None:
        self._sound_wanted = sound
        if self._video_lane is not None:
            self._video.choose(self._video_lane, size if picture else None)
        self._choose_sound()

    def follow(self, sync: SyncSettings) -> None:
        if sync is self._sync:
            return
        self._sync = sync
        self._policy = make_policy(sync)
        self._choose_sound()
        self._targets = None  # its name and reason are news even where its targets are not
        if self._is_ready:
            self._retarget(self._policy.start())

    def reported(self, report: PlayoutReport) -> None:
        self._retarget(self._policy.decide(report, self._clock.now_s()))

    def round_trip(self, round_trip_s: float) -> None: ...

    def received(self, kind: Kind, pts: int) -> None: ...

    def keyframe_wanted(self) -> None:
        if self._video_lane is not None:
            self._video.request_keyframe(self._video_lane)

    def status(self) -> dict[str, object]:
        return {"policy": self._policy.name}

    def _choose_sound(self) -> None:
        if self._sound_lane is not None:
            mu_ms = self._sync.audio_mu_ms if self._sound_wanted else None
            self._audio.choose(self._sound_lane, mu_ms, self._policy.preroll_ms)

    def _retarget(self, targets: PlayoutTargets) -> None:
        if self._targets is not None and not _moved(self._targets, targets):
            return
        self._targets = targets
        self._send(
            messages.Playout(
                policy=self._policy.name,
                sound_target_ms=targets.sound_ms,
                picture_target_ms=targets.picture_ms,
                reason=targets.reason,
            )
        )


class LiveService:
    """Makes the streams of a server whose viewers each have a policy of their own."""

    acknowledged = False

    def __init__(
        self, *, clock: Clock, settings: VideoSettings, video: VideoHub, audio: SoundHub
    ) -> None:
        self.codecs = Codecs(audio="opus", video=settings.codec)
        self._clock = clock
        self._video = video
        self._audio = audio

    @property
    def sizes(self) -> Sequence[str]:
        return self._video.sizes

    def streams(self, send: Callable[[BaseModel], None], sync: SyncSettings) -> LiveStreams:
        return LiveStreams(
            clock=self._clock, video=self._video, audio=self._audio, send=send, sync=sync
        )


def _moved(old: PlayoutTargets, new: PlayoutTargets) -> bool:
    def differ(a: float | None, b: float | None) -> bool:
        if a is None or b is None:
            return a is not b
        # A little is let be, but zero is always reached: nothing to hold back means none.
        return abs(a - b) >= _RETARGET_MS or (b == 0 and a != 0)

    return differ(old.sound_ms, new.sound_ms) or differ(old.picture_ms, new.picture_ms)
