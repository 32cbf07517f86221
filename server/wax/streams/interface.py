"""One viewer's streams: the interface between a viewer and the policy that serves them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

from wax.congestion.late_encoding import BESIDE
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic import BaseModel

    from wax.config.sync import SyncSettings
    from wax.congestion.control import CongestionControl
    from wax.error_boundary import ErrorBoundary
    from wax.protocol.messages import Served
    from wax.rtc.lane import PictureLane, SoundLane
    from wax.sync.playout import PlayoutReport

Kind = Literal["audio", "video"]
Policy = Literal["audio-master", "video-first"]


@dataclass(frozen=True, slots=True)
class Codecs:
    """The codecs on the wire, the same for everybody while the server runs."""

    audio: Literal["opus", "pcmu"]
    video: Literal["vp8", "h264"]
    cameras: frozenset[str] = frozenset()
    """The codecs of the cameras other than the driving view."""

    @property
    def names(self) -> frozenset[str]:
        """All codecs."""
        return self.cameras | {self.audio, self.video}

    @property
    def rates_hz(self) -> dict[Kind, int]:
        """RTP clocks (RFC 7587, 4.1; RFC 3551, table 4 and section 5)."""
        return {"audio": 48_000 if self.audio == "opus" else 8000, "video": 90_000}


@dataclass(frozen=True, slots=True)
class UnitPattern:
    """How a page recognises the last packet of each media unit of the sound.

    `last_pts` is the media time of one such packet, and `length` the distance to the next.
    """

    last_pts: int
    length: int


@dataclass(frozen=True, slots=True)
class MessageRate:
    """A token bucket's limits: twice what the busiest page sends."""

    rate_hz: float
    burst: int


@dataclass(frozen=True, slots=True)
class CameraLane:
    """The lane of a camera other than the driving view, and its codec."""

    lane: PictureLane
    codec: Literal["vp8", "h264"]


@dataclass(frozen=True, slots=True)
class Lanes:
    """A peer's lanes and its congestion control; `picture` is the driving view's lane."""

    picture: PictureLane
    sound: SoundLane
    congestion: CongestionControl
    cameras: Sequence[CameraLane] = ()


@dataclass(frozen=True, slots=True)
class SendingLimits:
    """What viewers are not sent, because this machine is too busy for it.

    `left` are sizes as `LateEncoding` has them, and `largest` is the largest that is sent;
    `observers_bps` is for all observers together, None without a limit.
    """

    left: Sequence[str] = ()
    largest: str = ""
    observers_bps: float | None = None

    def problems(self) -> list[Sentence]:
        """Return what the host should know."""
        found = []
        sizes = [one for one in self.left if one != BESIDE]
        if sizes:
            found.append(Sentence("busy.encoding", {"size": sizes[0], "largest": self.largest}))
        elif self.left:
            found.append(Sentence("busy.cameras"))
        if self.observers_bps is not None:
            found.append(Sentence("busy.loop"))
        return found


class StreamState(NamedTuple):
    """A viewer's entry in `GET /api/status`; the rest is None until something is decided."""

    entry: dict[str, object]
    served: Served | None = None
    lost: float | None = None


class Page(Protocol):
    """A viewer's page, as its streams use it."""

    @property
    def boundary(self) -> ErrorBoundary:
        """Wraps every call into this viewer from shared code; each peer has a new one."""
        ...

    def send(self, message: BaseModel) -> None:
        """Send on the reliable channel."""
        ...

    def set_playout_delay(self, least_ms: float) -> bool:
        """Delay pictures in the browser; False if it does not accept a delay from the server."""
        ...


class Streams(Protocol):
    """Lives as long as the viewer, and starts over with new lanes for each peer.

    No method raises for anything that a page does or omits.
    """

    def make_lanes(self) -> Lanes:
        """Make lanes for a new peer, and release those of the last one."""
        ...

    def release(self) -> None:
        """Release the lanes; safe to call twice."""
        ...

    def connected(self) -> None:
        """Start what may start before the page has sent its wishes."""
        ...

    def ready(self) -> None:
        """Send the page its initial state: the data channels are open."""
        ...

    def link_changed(self) -> None:
        """Start over, because the browser has changed to an unknown link."""
        ...

    def want(self, *, sound: bool, picture: bool, size: str, policy: Policy | None) -> None:
        """Change what is sent, with pictures of at most `size`, which is one of `sizes`.

        With `policy` None the role's policy applies.
        """
        ...

    def select_cameras(self, *, large: int | None, small: bool) -> None:
        """Select a camera to send with its whole ladder, None for none, and the others if `small`.

        `large` is a camera's number from 0; the driving view is always sent.
        """
        ...

    def set_role(self, sync: SyncSettings, *, drives: bool) -> None:
        """Change the policy with the role, without interrupting the streams."""
        ...

    def reported(self, report: PlayoutReport) -> None:
        """Handle a report on the playout of both streams."""
        ...

    def round_trip(self, round_trip_s: float) -> None:
        """Handle a measured round trip."""
        ...

    @property
    def is_thin(self) -> bool:
        """Whether the link is so slow that every datagram counts."""
        ...

    def file_sent(self, size_bytes: int) -> float | None:
        """Count a piece of a file that is sent now on a slow link.

        Return the pause before the next in s; None on a link that carries files without pauses.
        """
        ...

    def received(self, kind: Kind, pts: int) -> None:
        """Handle the page's acknowledgement of a media unit's last packet; `pts` modulo 2³²."""
        ...

    def keyframe_wanted(self, camera: int | None = None) -> None:
        """Handle a browser that cannot decode this camera's pictures; None is the driving view."""
        ...

    @property
    def units(self) -> UnitPattern | None:
        """The pattern by which the page acknowledges units; None if it should not, or not yet."""
        ...

    def status(self) -> StreamState: ...


class Service(Protocol):
    """Makes the viewers' streams; chosen once, when the server starts."""

    codecs: Codecs
    acknowledged: bool
    """Whether pages acknowledge what they receive. The HTML says so, as a page must know before it
    connects; `Hello` repeats it for a page that was loaded from another server."""
    state_messages: MessageRate
    """How often a page may write on the state channel."""

    @property
    def limits(self) -> SendingLimits:
        """What viewers are not sent just now, since the last `relieve`."""
        ...

    @property
    def has_room(self) -> bool:
        """Whether the robot's upload carries another observer with picture and sound."""
        ...

    def relieve(self, late_s: float) -> None:
        """Send observers less while the event loop is late; call it once a second.

        `late_s` is how late its work was on the mean of that second.
        """
        ...

    @property
    def sizes(self) -> Sequence[str]:
        """The sizes on offer, the default first."""
        ...

    @property
    def cameras(self) -> Sequence[str]:
        """The names of the cameras other than the driving view."""
        ...

    def streams(self, page: Page, sync: SyncSettings) -> Streams:
        """Make one viewer's streams."""
        ...
