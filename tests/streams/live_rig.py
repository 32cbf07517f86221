"""A viewer under the live policies; only time, encoders and the wire are simulated."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from tests.open_boundary import OpenFence
from tests.turned_clock import TurnedClock

from wax.config.audio import AudioSettings
from wax.config.sync import SyncSettings
from wax.config.video import VideoSettings
from wax.congestion.control import Delivery
from wax.encode.encoded import EncodedPicture
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.fanout.video_lane import VideoLane
from wax.streams.live import LiveService
from wax.sync.playout import PlayoutReport, StreamPlayout

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic import BaseModel

    from wax.congestion.control import CongestionControl, Train
    from wax.error_boundary import ErrorBoundary
    from wax.fanout.camera import Camera

SIZES = VideoSettings()


@dataclass
class Rig:
    """A viewer behind a link of `rate_bps`; only time, encoders and the wire are simulated."""

    rate_bps: float = 20e6
    takes_playout_delay: bool = True
    upload_bps: float = 0
    channels: int = 1
    cameras: Sequence[Camera] = ()
    clock: TurnedClock = field(default_factory=lambda: TurnedClock(100.0))
    told: list[BaseModel] = field(default_factory=list)
    held_ms: list[float] = field(default_factory=list)
    boundary: ErrorBoundary = field(default_factory=OpenFence)

    def __post_init__(self) -> None:
        self.video = VideoHub(settings=SIZES, clock=self.clock)
        self.audio = SoundHub(self.clock)
        self.service = LiveService(
            clock=self.clock,
            video_settings=SIZES,
            audio_settings=AudioSettings(),
            video=self.video,
            audio=self.audio,
            upload_bps=self.upload_bps,
            cameras=self.cameras,
        )
        self.streams = self.service.streams(self, SyncSettings())
        lanes = self.streams.make_lanes()
        assert isinstance(lanes.picture, VideoLane)
        self.lane, self.congestion = lanes.picture, lanes.congestion
        self.camera_lanes = [one.lane for one in lanes.cameras]
        self.asked: list[str] = []
        self.sizes: list[str] = []
        self.left = 0
        self._free_s = 0.0
        self._feedback: list[tuple[float, Delivery]] = []
        self._silent = False

    # The methods of a page.

    def send(self, message: BaseModel) -> None:
        self.told.append(message)

    def set_playout_delay(self, least_ms: float) -> bool:
        self.held_ms.append(least_ms)
        return self.takes_playout_delay

    def all(self, kind: type[BaseModel]) -> list[Any]:
        return [message for message in self.told if isinstance(message, kind)]

    # The roles of encoders and wire.

    def begin(self, *, sound: bool = True) -> None:
        self.streams.connected()
        self.streams.ready()
        self.streams.want(sound=sound, picture=True, size="640x480", policy=None)

    async def run(self, seconds: float) -> None:
        """Film, encode, send what congestion control permits, and report arrivals."""
        for tick in range(round(seconds * 100)):
            self.clock.time_s += 0.01
            now_s = self.clock.now_s()
            self.audio.channels = self.channels
            await asyncio.sleep(0)
            if tick % 2 == 0:
                self._wire(120, "audio", None)
            if tick % 4 == 0:
                for made in [self._picture(name, now_s) for name in self.video.wanted]:
                    self.video._fan_out(made)
                self._film(tick // 4, now_s)
            if (
                self.congestion.free_in_s(None, now_s) <= 0.001
                and (one := self.lane.pop_next()) is not None
            ):
                self.sizes.append(one.rendition)
                self._send(self.congestion, one)
            self._send_cameras(now_s)
            due = [one for at_s, one in self._feedback if at_s <= now_s]
            self._feedback = [one for one in self._feedback if one[0] > now_s]
            if due and not self._silent:
                self.congestion.delivered(due, now_s)

    def _film(self, number: int, now_s: float) -> None:
        """Film with the cameras, each at its rendition's rate."""
        for camera in self.cameras:
            for name in camera.hub.wanted:
                every = round(25 / camera.hub._renditions[name].settings.fps)
                if number % every == 0:
                    camera.hub._fan_out(self._picture(name, now_s, camera.hub))

    def _send_cameras(self, now_s: float) -> None:
        """Send cameras at a lower priority, as their senders do."""
        for lane in self.camera_lanes:
            is_free = self.lane.is_empty and self.congestion.free_in_s(None, now_s) <= 0.001
            if is_free and (one := lane.pop_next()) is not None:
                for _ in range(-(-len(one.data) // 1180)):
                    self._wire(1240, "video", None)

    def _picture(self, name: str, now_s: float, hub: VideoHub | None = None) -> EncodedPicture:
        rendition = (hub or self.video)._renditions[name]
        keyframe = rendition._keyframe.is_set()
        rendition._keyframe.clear()
        if keyframe:
            self.asked.append(name)
        mean = rendition.settings.bitrate_bps / rendition.settings.fps / 8
        data = bytes(round(mean * (3 if keyframe else 1)))
        return EncodedPicture(data, round(now_s * 90_000), name, keyframe, 0, now_s)

    def _send(self, congestion: CongestionControl, picture: EncodedPicture) -> None:
        size = len(picture.data)
        train: Train = congestion.plan_train(size, self.clock.now_s())
        while size > 0:
            self._wire(min(size, train.payload_bytes) + 62, "video", train.number)
            size -= train.payload_bytes
        self.left += 1

    def _wire(self, size: int, kind: Any, train: int | None) -> None:
        now_s = self.clock.now_s()
        self.congestion.sent(size, now_s, is_media=True)
        self._free_s = max(self._free_s, now_s) + size * 8 / self.rate_bps
        came = Delivery(now_s, 5000 + self._free_s + 0.02, size, kind, train)
        self._feedback.append((self._free_s + 0.06, came))

    def report(self, sound_ms: float | None, picture_ms: float | None) -> None:
        self.clock.time_s += 0.25
        played_ms = self.clock.time_s * 1000
        self.streams.reported(
            PlayoutReport(
                sound=None
                if sound_ms is None
                else StreamPlayout(age_ms=sound_ms, concealed_ms=0.0, played_ms=played_ms),
                picture=None if picture_ms is None else StreamPlayout(age_ms=picture_ms),
            )
        )


TOP, *_, BOTTOM = (one.name for one in SIZES.renditions)
