"""One viewer's streams: the interface between a viewer and the policy that serves them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic import BaseModel

    from wax.config.settings import SyncSettings
    from wax.congestion.control import CongestionControl
    from wax.error_boundary import ErrorBoundary
    from wax.rtc.lane import PictureLane, SoundLane
    from wax.sync.playout import PlayoutReport

Kind = Literal["audio", "video"]
Policy = Literal["audio-master", "video-first"]


@dataclass(frozen=True, slots=True)
class Codecs:
    """What is on the wire, the same for everybody as long as the server runs."""

    audio: Literal["opus", "pcmu"]
    video: Literal["vp8", "h264"]

    @property
    def rates_hz(self) -> dict[Kind, int]:
        """RTP clocks (RFC 7587, 4.1; RFC 3551, table 4 and section 5)."""
        return {"audio": 48_000 if self.audio == "opus" else 8000, "video": 90_000}


@dataclass(frozen=True, slots=True)
class Units:
    """How a page tells the last packet of each media unit of the sound.

    `last_pts` is the media time of one such packet, and `length` the way to the next.
    """

    last_pts: int
    length: int


@dataclass(frozen=True, slots=True)
class MessageRate:
    """What a token bucket lets through: twice what the liveliest page sends."""

    rate_hz: float
    burst: int


@dataclass(frozen=True, slots=True)
class Lanes:
    """What a peer sends, and the way by which it asks."""

    picture: PictureLane
    sound: SoundLane
    congestion: CongestionControl


class Page(Protocol):
    """A viewer's page, as their streams see it."""

    @property
    def boundary(self) -> ErrorBoundary:
        """Inside it whoever serves everybody calls into this viewer; each peer has a new one."""
        ...

    def send(self, message: BaseModel) -> None:
        """Send on the reliable channel."""
        ...

    def hold_back(self, least_ms: float) -> bool:
        """Let the browser show pictures this late; False where it does not take that from us."""
        ...


class Streams(Protocol):
    """Lives as long as the viewer; for each peer it begins anew with fresh lanes.

    Nothing here raises for what a page does or leaves undone.
    """

    def lanes(self) -> Lanes:
        """Make lanes for a fresh peer; those of the one before are given up."""
        ...

    def release(self) -> None:
        """Give up the lanes; safe to call twice."""
        ...

    def connected(self) -> None:
        """Start what may start before the page has said what it wants."""
        ...

    def ready(self) -> None:
        """Tell the page what it must know: the data channels are open."""
        ...

    def want(self, *, sound: bool, picture: bool, size: str, policy: Policy | None) -> None:
        """Send these from now on, pictures of `size` at most, which is one of those on offer.

        `policy` None is the role's.
        """
        ...

    def follow(self, sync: SyncSettings, *, drives: bool) -> None:
        """Change the policy with the role, without interrupting the streams."""
        ...

    def reported(self, report: PlayoutReport) -> None:
        """Handle a report on how both streams play."""
        ...

    def round_trip(self, round_trip_s: float) -> None:
        """Handle a measured round trip."""
        ...

    def received(self, kind: Kind, pts: int) -> None:
        """Handle the page's acknowledgement of a media unit's last packet; `pts` modulo 2³²."""
        ...

    def keyframe_wanted(self) -> None: ...

    @property
    def units(self) -> Units | None:
        """What the page needs in order to acknowledge, None if it should not, or not yet."""
        ...

    def status(self) -> dict[str, object]:
        """Return the viewer's entry in `GET /api/status`."""
        ...


class Service(Protocol):
    """Makes the viewers' streams; chosen once, when the server starts."""

    codecs: Codecs
    acknowledged: bool
    """Whether pages report what they have received. The HTML says so, since a page must know before
    it connects; `Hello` repeats it for a page that was loaded from another server."""
    state_messages: MessageRate
    """How often a page may write on the state channel."""

    @property
    def sizes(self) -> Sequence[str]:
        """The sizes on offer, the default first."""
        ...

    def streams(self, page: Page, sync: SyncSettings) -> Streams:
        """Make one viewer's streams."""
        ...
