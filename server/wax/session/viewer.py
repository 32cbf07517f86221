"""One viewer: their name, what they want, and their page's messages."""

from __future__ import annotations

import weakref
from contextlib import suppress
from typing import TYPE_CHECKING, Final, Protocol

import structlog

from wax.access import permissions
from wax.control.beats import Beats
from wax.control.command_freshness import CALM_HELD_S
from wax.control.controls import Operation
from wax.control.gate import Command
from wax.control.reasons import Refusal
from wax.error_boundary import ErrorBoundary
from wax.errors import ForbiddenError, ProtocolError
from wax.protocol import compact, messages
from wax.rate_limits import LastWins, TokenBucket
from wax.rtc.link_monitor import LinkMonitor
from wax.sentence import Sentence
from wax.session.diagnosis import for_guests
from wax.session.last_minute import LastMinute
from wax.session.names import clean_name
from wax.sync.playout import PlayoutReport, StreamPlayout
from wax.weak_callback import weak_callback

if TYPE_CHECKING:
    from pydantic import BaseModel

    from wax.access.admission import Grant, Visitor
    from wax.access.permissions import Role
    from wax.clock import Clock
    from wax.config.sync import SyncSettings
    from wax.rtc.peer import Channel, Peer
    from wax.streams.interface import Kind, Lanes, Service
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_DRIVE_HZ: Final = 100.0
_DRIVE_BURST: Final = 200
_COMMANDS_HZ: Final = 60.0
_COMMANDS_BURST: Final = 120
"""As many as a link may hold back in two seconds."""
_SETS_HZ: Final = 10.0
_SETS_BURST: Final = 20
"""The page repeats a setting until it is answered, so one over the rate is only delayed."""
_NAMES_HZ: Final = 0.5
_WANTS_HZ: Final = 1.0
_WANTS_BURST: Final = 8
"""Each may ask for another rendition, whose viewers then all get a keyframe."""
_KEYFRAMES_HZ: Final = 0.5
_KEYFRAMES_BURST: Final = 8
"""A browser repeats its request until a keyframe comes; everybody else pays for it."""
_MOVES_HZ: Final = 1.0
_MOVES_BURST: Final = 2
"""A phone may change the network and change back; a page that swaps addresses without end makes
the server pay for a change no more often than this."""
_DRIVE_STATUS_S: Final = 0.3
_THIN_DRIVE_STATUS_S: Final = 1.0
"""Over a thin link, where the status changes with every late picture."""
_MAX_STOP_CHARS: Final = 48
"""Longer messages over the rate limit are not even checked for a Stop."""


_ONLY_LATE: Final = (
    Refusal.OUT_OF_ORDER,
    Refusal.TOO_OLD,
    Refusal.TOO_SLOW,
    Refusal.FROM_FUTURE,
)
"""A message that is refused for one of these may count when the page repeats it."""

_NOT_UNDERSTOOD: Final = Sentence("request.not_understood")

Request = (
    messages.Join
    | messages.Leave
    | messages.Here
    | messages.KeepTape
    | messages.SetTask
    | messages.Disown
    | messages.Follow
)


class ViewerEvents(Protocol):
    """A viewer's events, which the room handles."""

    def viewer_connected(self, viewer: Viewer) -> None: ...

    def viewer_changed_network(self, viewer: Viewer) -> None: ...

    def viewer_closed(self, viewer: Viewer, peer: Peer) -> None: ...

    def viewer_role(self, viewer: Viewer) -> Role: ...

    def viewer_wants_name(self, viewer: Viewer, name: str) -> None: ...

    def viewer_asks(self, viewer: Viewer, request: Request) -> None: ...

    def viewer_acts(self, viewer: Viewer, act: messages.HostIn) -> None: ...

    def viewer_stops(self, viewer: Viewer, press: int | None) -> None: ...

    def viewer_releases(self, viewer: Viewer, release: messages.Release) -> None: ...

    def viewer_drives(self, viewer: Viewer, command: Command) -> None: ...

    def viewer_operates(self, viewer: Viewer, asked: Operation) -> Refusal | None: ...


class Viewer:
    """Lives from the first offer until the page has been gone for the grace time."""

    def __init__(
        self,
        *,
        number: int,
        visitor: Visitor,
        grant: Grant,
        tab: str,
        clock: Clock,
        counters: Counters,
        service: Service,
        events: ViewerEvents,
        sync: SyncSettings,
    ) -> None:
        self.number = number
        self.visitor = visitor
        self.grant = grant
        self.tab = tab
        self.name = _shown_name(visitor) or f"Guest {number}"
        self.since_s = clock.now_s()
        self.peer: Peer | None = None
        self.link = LinkMonitor(clock.now_s())
        self._beats = Beats()
        self.report: messages.Report | None = None
        self.concealed_ms = LastMinute()
        self.frozen_ms = LastMinute()
        self.is_ready = False
        self.was_ready = False
        self.follows = False
        """Whether this viewer wants the set-points."""
        self.wants_picture = True
        self._wanted: messages.Want | None = None
        self.in_room_until_s = float("-inf")
        """Until then the viewer watches in a LiveKit room and keeps a place here without a peer."""
        self._clock = clock
        self._counters = counters
        self._service = service
        self._events = events
        self.boundary = self._make_boundary()
        state = service.state_messages
        self.drive_status: messages.DriveStatus | None = None
        """The status of this viewer's commands, None before the first."""
        self._drive_sent: tuple[messages.DriveStatus | None, float] = (None, float("-inf"))
        self._is_misunderstood = False
        self._limits = {
            "drive": TokenBucket(_DRIVE_HZ, _DRIVE_BURST),
            "state": TokenBucket(state.rate_hz, state.burst),
        }
        self._commands = TokenBucket(_COMMANDS_HZ, _COMMANDS_BURST)
        self._sets = TokenBucket(_SETS_HZ, _SETS_BURST)
        self._keyframes = TokenBucket(_KEYFRAMES_HZ, _KEYFRAMES_BURST)
        self._names = LastWins(weak_callback(self._ask_name), TokenBucket(_NAMES_HZ, 1))
        self._wants = LastWins(
            weak_callback(self._choose_streams), TokenBucket(_WANTS_HZ, _WANTS_BURST)
        )
        self._looks = LastWins(
            weak_callback(self._choose_cameras), TokenBucket(_WANTS_HZ, _WANTS_BURST)
        )
        self._moves = LastWins(
            weak_callback(self._restart_streams), TokenBucket(_MOVES_HZ, _MOVES_BURST)
        )
        self._camera_keyframes = TokenBucket(_KEYFRAMES_HZ, _KEYFRAMES_BURST)
        self.streams = service.streams(weakref.proxy(self), sync)

    def update_access(self, visitor: Visitor, grant: Grant) -> None:
        """Replace visitor and grant; start or stop the sound if the right to hear has changed."""
        may_hear, self.visitor, self.grant = self.grant.hear, visitor, grant
        self.name = _shown_name(visitor) or self.name
        if grant.hear != may_hear and self._wanted is not None:
            with self.boundary:
                self._choose_streams(self._wanted)

    def is_in_room(self, now_s: float) -> bool:
        """Whether this viewer watches in a LiveKit room, and only waits here."""
        return self.peer is None and now_s < self.in_room_until_s

    # --- the peer's life -------------------------------------------------------------------

    def make_lanes(self) -> Lanes:
        """Make lanes for a new peer and release those of the previous one."""
        self.release()
        self.link = LinkMonitor(self._clock.now_s())
        self._beats = Beats()
        self.boundary = self._make_boundary()
        return self.streams.make_lanes()

    def release(self) -> None:
        """Release the lanes; safe to call twice."""
        self.streams.release()
        self.is_ready = self.follows = False
        self._wanted = None
        self.report = None
        self.drive_status, self._drive_sent = None, (None, float("-inf"))
        self._is_misunderstood = False

    def _make_boundary(self) -> ErrorBoundary:
        return ErrorBoundary(
            viewer=self.number, counters=self._counters, end=weak_callback(self._end_peer)
        )

    def _end_peer(self) -> None:
        if self.peer is not None:
            self.peer.abandon()

    async def close(self) -> None:
        """Close the peer, if there is one; never raises."""
        with self.boundary:
            if self.peer is not None:
                await self.peer.close()

    def connected(self) -> None:
        self.link.record_arrival(self._clock.now_s())
        self.streams.connected()

    def ready(self) -> None:
        self.is_ready = self.was_ready = True
        self.link.record_arrival(self._clock.now_s())
        self._events.viewer_connected(self)
        self.streams.ready()

    def network_changed(self) -> None:
        self.link = LinkMonitor(self._clock.now_s())  # the other network had another delay
        self._events.viewer_changed_network(self)
        self._moves.submit(None, self._clock.now_s())

    def _restart_streams(self, _moved: None) -> None:
        _LOG.info("a viewer goes on from another address", viewer=self.number)
        with self.boundary:
            self.streams.link_changed()
            self.keyframe_wanted()

    def closed(self, peer: Peer) -> None:
        self._events.viewer_closed(self, peer)

    def keyframe_wanted(self, camera: int | None = None) -> None:
        # Two budgets, so that losses on other cameras never cost the driving view a keyframe.
        bucket = self._keyframes if camera is None else self._camera_keyframes
        if not bucket.take(self._clock.now_s()):
            self._counters.add("keyframes refused")
            return
        self._counters.add("keyframes asked for")
        self.streams.keyframe_wanted(camera)

    def feedback_refused(self) -> None:
        self._counters.add("feedback refused")

    def rtp_clock(self, kind: Kind, rtp: int, captured_s: float) -> None:
        self.send(
            messages.RtpClock(
                kind=kind,
                rtp_origin=rtp,
                rate_hz=self._service.codecs.rates_hz[kind],
                origin_server_ms=captured_s * 1000,
            )
        )
        units = self.streams.units
        if kind == "audio" and units is not None and self.peer is not None:
            last_rtp = self.peer.rtp_time("audio", units.last_pts)
            self.send(messages.Units(last_rtp=last_rtp, length=units.length))

    # --- to the page -----------------------------------------------------------------------

    @property
    def knows_faults(self) -> bool:
        """Whether this viewer may read the details of faults."""
        return permissions.may(self._events.viewer_role(self), permissions.DIAGNOSIS)

    def send(self, message: BaseModel) -> None:
        """Send on the reliable channel, without the details of faults unless `knows_faults`."""
        known = message if self.knows_faults else for_guests(message)
        self.send_text(known.model_dump_json())

    def send_text(self, text: str) -> None:
        """Send a text that was encoded once for everybody."""
        self._send("state", text)

    def _send(self, channel: Channel, text: str) -> None:
        with self.boundary:
            if self.peer is not None:
                self.peer.send(channel, text)

    def request_name(self, name: str) -> None:
        """Ask the room for this name, at most once in two seconds; the last request wins."""
        self._names.submit(name, self._clock.now_s())

    @property
    def has_name_waiting(self) -> bool:
        return self._names.is_waiting

    def run_deferred_name(self, now_s: float) -> None:
        """Run the deferred request for a name: comparing it with all others takes a millisecond."""
        self._names.run_waiting(now_s)

    def run_deferred(self, now_s: float) -> None:
        """Run the deferred requests, except for a name; call it a few times a second."""
        self._wants.run_waiting(now_s)
        self._looks.run_waiting(now_s)
        self._moves.run_waiting(now_s)
        self.send_drive_status(now_s)

    def send_drive_status(self, now_s: float) -> None:
        """Send the status of the commands when it has changed, a few times a second at most.

        On a bad link every second command may be too old; reporting each would add to the load.
        """
        if not self.is_ready:
            return  # send it once the page is connected
        sent, sent_s = self._drive_sent
        every_s = _THIN_DRIVE_STATUS_S if self.streams.is_thin else _DRIVE_STATUS_S
        if self.drive_status not in (None, sent) and now_s - sent_s >= every_s:
            self._drive_sent = self.drive_status, now_s
            self.send(self.drive_status)

    def set_playout_delay(self, least_ms: float) -> bool:
        """Make the browser hold pictures back for at least this long; False if it cannot."""
        return self.peer is not None and self.peer.set_playout_delay(least_ms)

    def set_role(self, sync: SyncSettings, *, drives: bool) -> None:
        """Apply the policy of a new role, without interrupting the streams."""
        self.streams.set_role(sync, drives=drives)

    # --- from the page ---------------------------------------------------------------------

    def received(self, channel: Channel, data: str | bytes) -> None:
        """Handle a message; never raises, since that would close the peer.

        A viewer who was sent away stays connected for a moment, and is ignored.
        """
        if self.peer is None:
            return
        now_s = self._clock.now_s()
        self.link.record_arrival(now_s)
        if not self._limits[channel].take(now_s) and not _is_stop(channel, data):
            self._counters.add("messages over the rate")
            return
        try:
            message = _parsed(channel, data)
            permissions.check(self._events.viewer_role(self), type(message))
            if isinstance(message, messages.DriveIn):
                self._on_drive(message)
            else:
                self._on_state(message)
        except ForbiddenError as error:
            self._counters.add("messages not allowed")
            if channel == "state":
                self.send(messages.Notice(text=error.sentence))
        except ProtocolError as error:
            self._counters.add("messages refused")
            _LOG.debug("message refused", viewer=self.number, error=str(error))
            self._report_misunderstood()
        except Exception:
            self._counters.add("messages failed")
            _LOG.exception("message failed", viewer=self.number, channel=channel)

    def _report_misunderstood(self) -> None:
        """Tell the page, once per connection: it may predate an update, and drive in vain."""
        if self.is_ready and not self._is_misunderstood:
            self._is_misunderstood = True
            self.send(messages.Notice(text=_NOT_UNDERSTOOD))

    def _on_drive(self, message: messages.DriveIn) -> None:
        now_s = self._clock.now_s()
        match message:
            case messages.Drive():
                # A command that holds nothing can only stop the robot.
                if message.held and not self._commands.take(now_s):
                    self._counters.add("messages over the rate")
                    return
                heard_s = self._beats.sent_s(message.beat)
                seen_s = self._seen_s(message)
                self._events.viewer_drives(self, command_of(message, heard_s, seen_s))
                self._send_beat(now_s)
            case messages.Operate():
                self._operate(message, now_s)
                self._send_beat(now_s)
            case messages.Ping():
                round_trip_s = self.link.handle_ping(
                    message.id, message.pong_id, message.pong_held_ms, now_s
                )
                if round_trip_s is not None:
                    self.streams.round_trip(round_trip_s)
                pong = messages.Pong(
                    id=message.id,
                    sent_page_ms=message.sent_page_ms,
                    server_ms=now_s * 1000,
                    beat=self._beats.send(now_s),
                )
                self._send("drive", compact.write(pong))
            case messages.Report():
                self.report = message
                sound, picture = message.sound, message.picture
                self.concealed_ms.count(None if sound is None else sound.concealed_ms, now_s)
                self.frozen_ms.count(None if picture is None else picture.frozen_ms, now_s)
                self.streams.reported(_playout(message))

    def _seen_s(self, message: messages.Drive) -> float | None:
        """Return the capture time of the picture on the page: at most the newest one sent."""
        sent_s = None if self.peer is None else self.peer.newest_picture_s
        if message.seen_server_ms is None or sent_s is None:
            return None
        return min(message.seen_server_ms / 1000, sent_s)

    def _send_beat(self, now_s: float) -> None:
        """Send a beat if one is due: a command that quotes no recent beat is refused."""
        if not self._beats.is_due(now_s, is_thin=False):
            return
        if self._beats.is_due(now_s, is_thin=self.streams.is_thin):
            self._send("drive", compact.write(messages.Beat(beat=self._beats.send(now_s))))

    def release_sent_s(self, release: messages.Release) -> float:
        """Return when a release of Stop counts as sent; its beat limits how late that can be."""
        return min(release.sent_server_ms / 1000, self._beats.sent_s(release.beat) + CALM_HELD_S)

    def _operate(self, message: messages.Operate, now_s: float) -> None:
        if message.wanted and not self._sets.take(now_s):
            self._counters.add("messages over the rate")
            return
        refusal = self._events.viewer_operates(
            self, operation_of(message, self._beats.sent_s(message.beat))
        )
        if message.wanted or message.held:
            if refusal in _ONLY_LATE:
                return
            refused = None if refusal is None else refusal.value
            operated = messages.Operated(seq=message.seq, refused=refused)
            self._send("drive", compact.write(operated))

    def _on_state(self, message: messages.StateIn) -> None:
        match message:
            case messages.SetName():
                self.request_name(message.name)
            case messages.Stop():
                self._events.viewer_stops(self, message.press)
            case messages.Release():
                self._events.viewer_releases(self, message)
            case messages.Want():
                self._wants.submit(message, self._clock.now_s())
            case messages.Look():
                self._looks.submit(message, self._clock.now_s())
            case messages.Received():
                self._received(message)
            case _ if isinstance(message, Request):
                self._events.viewer_asks(self, message)
            case _:
                self._events.viewer_acts(self, message)

    def _ask_name(self, name: str) -> None:
        self._events.viewer_wants_name(self, clean_name(name))

    def _choose_streams(self, want: messages.Want) -> None:
        if want.size not in self._service.sizes:
            self._counters.add("requests refused")
            sizes = ", ".join(self._service.sizes)
            refusal = Sentence("want.no_size", {"size": want.size, "sizes": sizes})
            self.send(messages.Notice(text=refusal))
            return
        self._wanted = want
        self.wants_picture = want.picture
        self.streams.want(
            sound=want.sound and self.grant.hear,
            picture=want.picture,
            size=want.size,
            policy=want.policy,
        )

    def _choose_cameras(self, look: messages.Look) -> None:
        if look.large is not None and look.large >= len(self._service.cameras):
            self._counters.add("requests refused")
            refusal = Sentence("want.no_camera", {"number": look.large + 1})
            self.send(messages.Notice(text=refusal))
            return
        self.streams.select_cameras(large=look.large, small=look.small)

    def _received(self, received: messages.Received) -> None:
        if self.peer is not None:
            pts = self.peer.media_time(received.kind, received.rtp)
            self.streams.received(received.kind, pts)


def _shown_name(visitor: Visitor) -> str:
    """Return the name by which a proxy knows somebody, empty if it tells none."""
    return "" if visitor.vouched is None else clean_name(visitor.vouched.name)


def _parsed(channel: Channel, data: str | bytes) -> messages.DriveIn | messages.StateIn:
    return messages.parse_drive(data) if channel == "drive" else messages.parse_state(data)


def _is_stop(channel: Channel, data: str | bytes) -> bool:
    """Whether this is a Stop, the only message without a rate limit."""
    if channel != "state" or len(data) > _MAX_STOP_CHARS:
        return False
    with suppress(ProtocolError):
        return isinstance(messages.parse_state(data), messages.Stop)
    return False


def command_of(message: messages.Drive, heard_s: float, seen_s: float | None) -> Command:
    """Convert a page's set-point; its timestamps become seconds."""
    return Command(
        seq=message.seq,
        turn=message.turn,
        sent_s=message.sent_server_ms / 1000,
        linear=message.linear,
        angular=message.angular,
        lateral=message.lateral,
        held=message.held,
        speed=message.speed,
        seen_s=seen_s,
        axes=message.axes,
        heard_s=heard_s,
    )


def operation_of(message: messages.Operate, heard_s: float) -> Operation:
    """Convert a page's request to the controls; its timestamp becomes seconds."""
    return Operation(
        seq=message.seq,
        turn=message.turn,
        sent_s=message.sent_server_ms / 1000,
        held=message.held,
        wanted=message.wanted,
        heard_s=heard_s,
    )


def _playout(report: messages.Report) -> PlayoutReport:
    sound, picture = report.sound, report.picture
    return PlayoutReport(
        sound=None
        if sound is None
        else StreamPlayout(
            age_ms=sound.age_ms,
            delay_ms=sound.delay_ms,
            concealed_ms=sound.concealed_ms,
            played_ms=sound.played_ms,
            output_ms=sound.output_ms,
            is_built_in=sound.player == "built-in",
        ),
        picture=None
        if picture is None
        else StreamPlayout(age_ms=picture.age_ms, delay_ms=picture.delay_ms),
    )
