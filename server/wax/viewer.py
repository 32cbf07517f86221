"""One viewer: who he is, what he wants, and what his page says."""

from __future__ import annotations

import unicodedata
from typing import TYPE_CHECKING, Final, Protocol

import structlog

from wax import messages
from wax.control.gate import Command
from wax.errors import ProtocolError
from wax.limiter import TokenBucket
from wax.media.encoded import VIDEO_RATE_HZ
from wax.media.source import SAMPLE_RATE_HZ
from wax.rtc.link import Link
from wax.sync.playout import PlayoutReport, PlayoutTargets, StreamPlayout
from wax.sync.policies import make_policy

if TYPE_CHECKING:
    from pydantic import BaseModel

    from wax.clock import Clock
    from wax.config import SyncSettings
    from wax.media.lane import SoundLane, VideoLane
    from wax.media.sound_hub import SoundHub
    from wax.media.video_hub import VideoHub
    from wax.rtc.peer import Channel, Kind, Peer
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_RETARGET_MS: Final = 4.0
"""A buffer is not retargeted for less: each change of the picture's is a small jump."""

_DRIVE_HZ: Final = 100.0
_DRIVE_BURST: Final = 200
_STATE_HZ: Final = 20.0
_STATE_BURST: Final = 60
"""Twice what the liveliest page sends; what is beyond is not even read."""

_RATES: Final[dict[Kind, int]] = {"audio": SAMPLE_RATE_HZ, "video": VIDEO_RATE_HZ}


class ViewerEvents(Protocol):
    """What the room does for a viewer."""

    def viewer_connected(self, viewer: Viewer) -> None: ...

    def viewer_closed(self, viewer: Viewer, peer: Peer) -> None: ...

    def viewer_renamed(self) -> None: ...

    def viewer_asks(self, viewer: Viewer, request: messages.Join | messages.Leave) -> None: ...

    def viewer_stops(self, viewer: Viewer) -> None: ...

    def viewer_drives(self, viewer: Viewer, command: Command) -> None: ...


class Viewer:
    """Lives from the first offer until his page has been gone for the time of grace."""

    def __init__(
        self,
        *,
        number: int,
        client: str,
        clock: Clock,
        counters: Counters,
        video: VideoHub,
        audio: SoundHub,
        events: ViewerEvents,
        sync: SyncSettings,
    ) -> None:
        self.number = number
        self.client = client
        self.name = f"Guest {number}"
        self.peer: Peer | None = None
        self.link = Link(clock.now_s())
        self.report: messages.Report | None = None
        self.is_ready = False
        self.was_ready = False
        self._clock = clock
        self._counters = counters
        self._video = video
        self._audio = audio
        self._events = events
        self._limits = {
            "drive": TokenBucket(rate_hz=_DRIVE_HZ, burst=_DRIVE_BURST, now_s=clock.now_s()),
            "state": TokenBucket(rate_hz=_STATE_HZ, burst=_STATE_BURST, now_s=clock.now_s()),
        }
        self._sync = sync
        self._policy = make_policy(sync)
        self._targets: PlayoutTargets | None = None
        self._sound_wanted = False
        self._video_lane: VideoLane | None = None
        self._sound_lane: SoundLane | None = None

    # --- the peer's life -------------------------------------------------------------------

    def lanes(self) -> tuple[VideoLane, SoundLane]:
        """Make fresh lanes for a fresh peer; those of the peer before are given up."""
        self.release()
        self._video_lane = self._video.add()
        self._sound_lane = self._audio.add()
        self.link = Link(self._clock.now_s())
        return self._video_lane, self._sound_lane

    def release(self) -> None:
        """Give up the lanes; safe to call twice."""
        if self._video_lane is not None and self._sound_lane is not None:
            self._video.remove(self._video_lane)
            self._audio.remove(self._sound_lane)
        self._video_lane = self._sound_lane = None
        self.is_ready = False
        self._sound_wanted = False
        self._targets = None
        self.report = None

    def connected(self) -> None:
        """Start the picture before the page can ask for it: it plays on load."""
        self.link.heard(self._clock.now_s())
        if self._video_lane is not None:
            self._video.choose(self._video_lane, self._video.sizes[0])

    def ready(self) -> None:
        self.is_ready = self.was_ready = True
        self.link.heard(self._clock.now_s())
        self._events.viewer_connected(self)
        self._retarget(self._policy.start())

    def closed(self, peer: Peer) -> None:
        self._events.viewer_closed(self, peer)

    def keyframe_wanted(self) -> None:
        if self._video_lane is not None:
            self._counters.add("keyframes asked for")
            self._video.request_keyframe(self._video_lane)

    def rtp_clock(self, kind: Kind, rtp: int, captured_s: float) -> None:
        self.send(
            messages.RtpClock(
                kind=kind,
                rtp_origin=rtp,
                rate_hz=_RATES[kind],
                origin_server_ms=captured_s * 1000,
            )
        )

    # --- to the page -----------------------------------------------------------------------

    def send(self, message: BaseModel) -> None:
        """Send on the reliable channel."""
        self.send_text(message.model_dump_json())

    def send_text(self, text: str) -> None:
        """Send what was made once for everybody."""
        if self.peer is not None:
            self.peer.send("state", text)

    def follow(self, sync: SyncSettings) -> None:
        """Change the policy with the role, while the streams go on."""
        if sync is self._sync:
            return
        self._sync = sync
        self._policy = make_policy(sync)
        self._choose_sound()
        if self.is_ready:
            self._retarget(self._policy.start())

    # --- from the page ---------------------------------------------------------------------

    def received(self, channel: Channel, data: str | bytes) -> None:
        """Take a message; never raises, since that would close the peer."""
        now_s = self._clock.now_s()
        self.link.heard(now_s)
        if not self._limits[channel].take(now_s):
            self._counters.add("messages over the rate")
            return
        try:
            if channel == "drive":
                self._on_drive(messages.parse_drive(data))
            else:
                self._on_state(messages.parse_state(data))
        except ProtocolError as error:
            self._counters.add("messages refused")
            _LOG.debug("message refused", viewer=self.number, error=str(error))
        except Exception:
            self._counters.add("messages failed")
            _LOG.exception("message failed", viewer=self.number, channel=channel)

    def _on_drive(self, message: messages.Drive | messages.Ping | messages.Report) -> None:
        now_s = self._clock.now_s()
        match message:
            case messages.Drive():
                self._events.viewer_drives(self, _command(message))
            case messages.Ping():
                self.link.pinged(message.id, message.pong_id, message.pong_held_ms, now_s)
                pong = messages.Pong(
                    id=message.id, sent_page_ms=message.sent_page_ms, server_ms=now_s * 1000
                )
                if self.peer is not None:
                    self.peer.send("drive", pong.model_dump_json())
            case messages.Report():
                self.report = message
                self._retarget(self._policy.decide(_playout(message), now_s))

    def _on_state(
        self,
        message: messages.SetName | messages.Join | messages.Leave | messages.Stop | messages.Want,
    ) -> None:
        match message:
            case messages.SetName():
                self._rename(message.name)
            case messages.Join() | messages.Leave():
                self._events.viewer_asks(self, message)
            case messages.Stop():
                self._events.viewer_stops(self)
            case messages.Want():
                self._want(message)

    def _rename(self, name: str) -> None:
        self.name = clean_name(name) or f"Guest {self.number}"
        self._events.viewer_renamed()

    def _want(self, want: messages.Want) -> None:
        if want.size not in self._video.sizes:
            self._counters.add("requests refused")
            sizes = ", ".join(self._video.sizes)
            self.send(messages.Notice(text=f"There is no size {want.size}; choose of {sizes}."))
            return
        self._sound_wanted = want.sound
        if self._video_lane is not None:
            self._video.choose(self._video_lane, want.size if want.picture else None)
        self._choose_sound()

    def _choose_sound(self) -> None:
        if self._sound_lane is not None:
            mu_ms = self._sync.audio_mu_ms if self._sound_wanted else None
            self._audio.choose(self._sound_lane, mu_ms, self._policy.preroll_ms)

    def _retarget(self, targets: PlayoutTargets) -> None:
        if self._targets is not None and not _moved(self._targets, targets):
            return
        self._targets = targets
        self.send(
            messages.Playout(
                policy=self._policy.name,
                sound_target_ms=targets.sound_ms,
                picture_target_ms=targets.picture_ms,
                reason=targets.reason,
            )
        )


def clean_name(name: str) -> str:
    """Make one line of visible characters of a name, at most `MAX_NAME_CHARS` long."""
    visible = "".join(c if unicodedata.category(c)[0] not in "CZ" else " " for c in name)
    return " ".join(visible.split())[: messages.MAX_NAME_CHARS].strip()


def _command(message: messages.Drive) -> Command:
    return Command(
        seq=message.seq,
        turn=message.turn,
        sent_s=message.sent_server_ms / 1000,
        linear=message.linear,
        angular=message.angular,
        speed=message.speed,
        seen_s=None if message.seen_server_ms is None else message.seen_server_ms / 1000,
        axes=message.axes,
    )


def _playout(report: messages.Report) -> PlayoutReport:
    def stream(one: messages.StreamReport | None) -> StreamPlayout | None:
        return None if one is None else StreamPlayout(age_ms=one.age_ms, delay_ms=one.delay_ms)

    return PlayoutReport(sound=stream(report.sound), picture=stream(report.picture))


def _moved(old: PlayoutTargets, new: PlayoutTargets) -> bool:
    def differ(a: float | None, b: float | None) -> bool:
        if a is None or b is None:
            return a is not b
        # A little is let be, but zero is always reached: nothing to hold back means none.
        return abs(a - b) >= _RETARGET_MS or (b == 0 and a != 0)

    return differ(old.sound_ms, new.sound_ms) or differ(old.picture_ms, new.picture_ms)
