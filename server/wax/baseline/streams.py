"""`thesis`: serves every viewer as in 2004, with the sender of `wax.baseline`.

Sound has priority because it is sent first. DSCP is not set (thesis 4.2: setsockopt, iptables):
sound and picture share one bundled UDP socket (RFC 9143) and would get the same mark.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Final

from wax.baseline.compensation import Compensation
from wax.baseline.media_units import MediaUnit, Stream
from wax.baseline.unit_lane import PictureIntake, UnitLane
from wax.baseline.unit_sender import UnitSender
from wax.config.video import RenditionSettings, VideoSettings
from wax.congestion.control import CongestionControl
from wax.protocol import messages
from wax.sentence import Sentence
from wax.streams.interface import (
    Codecs,
    Kind,
    Lanes,
    MessageRate,
    Policy,
    SendingLimits,
    StreamState,
    UnitPattern,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from wax.baseline.unit_hub import UnitHub
    from wax.baseline.unit_sender import Decision, Mode
    from wax.clock import Clock
    from wax.config.sync import SyncSettings
    from wax.config.thesis import ThesisSettings
    from wax.encode.encoded import EncodedPicture, EncodedSound, SoundUnit
    from wax.fanout.video_hub import VideoHub
    from wax.streams.interface import Page
    from wax.sync.playout import PlayoutReport

    Packets = tuple[EncodedPicture | EncodedSound, ...]

_UINT32: Final = 2**32
_MODES: Final[Mapping[Mode, Sentence]] = {
    "one stream": Sentence("thesis.one_stream"),
    "start-up": Sentence("thesis.start_up"),
    "synchronised": Sentence("thesis.synchronised"),
}
_STREAMS: Final[dict[Kind, Stream]] = {"audio": "sound", "video": "picture"}


class BaselineStreams:
    """Passes captured units to one viewer's sender, and carries out its decisions."""

    def __init__(
        self,
        *,
        clock: Clock,
        settings: ThesisSettings,
        video: VideoHub,
        audio: UnitHub,
        page: Page,
    ) -> None:
        self._clock = clock
        self._settings = settings
        self._video = video
        self._audio = audio
        self._page = page
        self._lanes: dict[Stream, UnitLane[Any]] = {}
        self._intake: PictureIntake | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._told: Sentence | None = None
        self._fail_safe_s = 0.0
        self._fail_safe_since_s: float | None = None
        self._reset()

    def _reset(self) -> None:
        """Reset all knowledge of the link and everything queued."""
        self._sender = UnitSender(self._settings, sound=False, picture=False)
        self._compensation = Compensation(self._settings)
        self._extra_s = 0.0
        self._payloads: dict[tuple[Stream, int], Packets] = {}
        self._under_way: dict[Stream, tuple[int, int]] = {}
        self._last_sound_pts: int | None = None
        self._counts = {"sent": 0, "skipped": 0, "lost": 0}

    # --- the peer's life -------------------------------------------------------------------

    def make_lanes(self) -> Lanes:
        self.release()
        self._reset()
        picture: UnitLane[EncodedPicture] = UnitLane()
        sound: UnitLane[EncodedSound] = UnitLane()
        self._lanes = {"picture": picture, "sound": sound}
        self._intake = PictureIntake(self._picture_captured)
        self._video.attach(self._intake, self._page.boundary)
        # The sender decides what is sent, and after that nothing is queued.
        return Lanes(picture, sound, CongestionControl())

    def release(self) -> None:
        if self._intake is not None:
            self._video.remove(self._intake)
            self._intake = None
        self._audio.leave(self._sound_captured)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._lanes = {}
        self._under_way.clear()
        self._told = None
        self._note_mode(None)

    def connected(self) -> None:
        """Do nothing: the page can acknowledge units only once it has sent its wishes."""

    def ready(self) -> None:
        self._notify_page()

    def link_changed(self) -> None:
        """Do nothing: every picture is a keyframe, and acknowledgements measure the new link."""

    def want(
        self,
        *,
        sound: bool,
        picture: bool,
        size: str,  # noqa: ARG002  # there is only one size
        policy: Policy | None,  # noqa: ARG002  # the baseline is the same for everybody
    ) -> None:
        if self._intake is None:
            return
        self._video.choose(self._intake, self._video.names[0] if picture else None)
        if sound:
            self._audio.listen(self._sound_captured, self._page.boundary)
        else:
            self._audio.leave(self._sound_captured)
        self._apply(self._sender.choose(sound=sound, picture=picture, now_s=self._clock.now_s()))

    def select_cameras(self, *, large: int | None, small: bool) -> None:
        """Do nothing: there is one picture."""

    def set_role(self, sync: SyncSettings, *, drives: bool) -> None:
        """Do nothing: the baseline is the same for all roles."""

    def keyframe_wanted(self, camera: int | None = None) -> None:
        """Do nothing: every picture is a keyframe."""

    # --- captured units --------------------------------------------------------------------

    def _sound_captured(self, unit: SoundUnit) -> None:
        self._last_sound_pts = unit.packets[-1].pts
        length_s = self._settings.audio_mu_ms / 1000
        self._captured(MediaUnit("sound", unit.number, unit.captured_s, length_s), unit.packets)

    def _picture_captured(self, number: int, picture: EncodedPicture) -> None:
        # A picture is taken at the end of its interval.
        length_s = self._settings.video_mu_ms / 1000
        began_s = picture.captured_s - length_s
        self._captured(MediaUnit("picture", number, began_s, length_s), (picture,))

    def _captured(self, unit: MediaUnit, packets: Packets) -> None:
        if not self._lanes:
            return
        self._payloads[unit.stream, unit.number] = packets
        self._apply(self._sender.captured(unit, self._clock.now_s()))

    # --- messages of the page --------------------------------------------------------------

    def received(self, kind: Kind, pts: int) -> None:
        stream = _STREAMS[kind]
        if (under_way := self._under_way.get(stream)) is None:
            return
        number, last_pts = under_way
        if last_pts % _UINT32 == pts:
            del self._under_way[stream]
            self._apply(self._sender.acknowledged(stream, number, self._clock.now_s()))

    def round_trip(self, round_trip_s: float) -> None:
        if self._lanes:
            self._apply(self._sender.round_trip(round_trip_s, self._clock.now_s()))

    @property
    def is_thin(self) -> bool:
        return True  # no rate is estimated, and modems are measured, too

    def file_sent(self, size_bytes: int) -> float | None:  # noqa: ARG002  # files are not paced
        return None

    def reported(self, report: PlayoutReport) -> None:
        now_s = self._clock.now_s()
        state = self._sender.state()
        rollback_s = state.rollback_s if state.mode == "synchronised" else None
        extra_s = self._compensation.reported(report, rollback_s, now_s)
        if extra_s != self._extra_s and self._lanes:
            self._extra_s = extra_s
            self._apply(self._sender.roll_back_further(extra_s, now_s))

    # --- decisions -------------------------------------------------------------------------

    def _apply(self, decision: Decision) -> None:
        """Carry out a decision; sound is first in it, and therefore on the wire."""
        for unit in decision.send:
            packets = self._payloads.pop((unit.stream, unit.number))
            self._under_way[unit.stream] = (unit.number, packets[-1].pts)
            self._lanes[unit.stream].put(packets)
            self._counts["sent"] += 1
        for unit in decision.skipped:
            del self._payloads[unit.stream, unit.number]
            self._missed("skipped", unit.stream)
        for unit in decision.lost:
            self._missed("lost", unit.stream)
            if self._under_way.get(unit.stream, (None, 0))[0] == unit.number:
                del self._under_way[unit.stream]
        self._notify_page()
        if self._timer is not None:
            self._timer.cancel()
        wait_s = max(decision.wake_s - self._clock.now_s(), 0.0)
        self._timer = asyncio.get_running_loop().call_later(
            wait_s, self._page.boundary.around(self._tick)
        )

    def _tick(self) -> None:
        self._apply(self._sender.tick(self._clock.now_s()))

    def _missed(self, how: str, stream: Stream) -> None:
        self._counts[how] += 1
        if stream == "sound":
            self._audio.dropped += 1
        elif self._intake is not None:
            self._intake.dropped += 1

    def _notify_page(self) -> None:
        """Notify the page when its mode has changed."""
        state = self._sender.state()
        self._note_mode(state.mode)
        reason = _words(state.mode, state.reason)
        if reason == self._told or not self._lanes:
            return
        self._told = reason
        # The browser's buffers should add no delay, because the server rolls back.
        self._page.send(
            messages.Playout(
                policy="thesis",
                player="browser",
                sound_target_ms=None,
                picture_target_ms=0.0,
                reason=reason,
            )
        )

    def _note_mode(self, mode: str | None) -> None:
        now_s = self._clock.now_s()
        if self._fail_safe_since_s is not None:
            self._fail_safe_s += now_s - self._fail_safe_since_s
        self._fail_safe_since_s = now_s if mode == "fail-safe" else None

    @property
    def units(self) -> UnitPattern | None:
        if self._last_sound_pts is None:
            return None
        return UnitPattern(last_pts=self._last_sound_pts, length=self._audio.unit_samples)

    def status(self) -> StreamState:
        state = self._sender.state()
        self._note_mode(state.mode if self._lanes else None)
        entry: dict[str, object] = {
            "policy": "thesis",
            "mode": state.mode,
            "reason": None if state.reason is None else str(state.reason),
            "hold_back_ms": _ms(state.hold_back_s),
            "transfer_ms": _ms(state.transfer_s),
            "rollback_ms": _ms(state.rollback_s),
            "pictures_cached": state.pictures_cached,
            "fail_safe_s": round(self._fail_safe_s, 3),
            **self._counts,
        }
        return StreamState(entry)


class BaselineService:
    """Makes the streams of a server that serves every viewer as in 2004."""

    acknowledged = True
    state_messages = MessageRate(rate_hz=120.0, burst=200)
    codecs = Codecs(audio="pcmu", video="vp8")
    has_room = True
    cameras: Sequence[str] = ()

    def __init__(
        self, *, clock: Clock, settings: ThesisSettings, video: VideoHub, audio: UnitHub
    ) -> None:
        self._clock = clock
        self._settings = settings
        self._video = video
        self._audio = audio

    limits = SendingLimits()

    def relieve(self, late_s: float) -> None: ...

    @property
    def sizes(self) -> Sequence[str]:
        return self._video.sizes

    def streams(
        self,
        page: Page,
        sync: SyncSettings,  # noqa: ARG002  # the baseline is the same for all roles
    ) -> BaselineStreams:
        return BaselineStreams(
            clock=self._clock,
            settings=self._settings,
            video=self._video,
            audio=self._audio,
            page=page,
        )


def thesis_video(video: VideoSettings, thesis: ThesisSettings) -> VideoSettings:
    """Return the settings with the thesis's one size, rate and codec."""
    fps = 1000 / thesis.video_mu_ms
    rendition = RenditionSettings(
        width=thesis.width,
        height=thesis.height,
        fps=fps,
        bitrate_bps=round(8 * thesis.picture_bytes * fps),
    )
    return video.model_copy(update={"codec": "vp8", "renditions": [rendition]})


def _words(mode: Mode, why: Sentence | None) -> Sentence:
    return _MODES[mode] if why is None else Sentence("thesis.fail_safe", {"why": why})


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds * 1000, 1)
