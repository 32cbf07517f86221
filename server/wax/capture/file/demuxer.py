"""One demuxer for the picture and the sound of a file or stream address, in its own thread.

It reads packets a little ahead, maps them to a timeline on the monotonic clock and puts each into
the queue of its stream. The reader of a queue decodes, so an unused stream costs nothing. There are
two kinds of address:

* **paced** (files, HLS, DASH): played at their own speed by their timestamps, and reopened at the
  end, so that every pass is like the first and follows without a gap;
* **live** (RTSP, RTP, RTMP, SRT, endless HTTP, …): passed on as packets arrive, so that delay
  cannot build up, and dated by arrival and stamps (`wax.capture.stream_dating`).
"""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal

import structlog
from av.error import FFmpegError

from wax.capture.file.address import (
    Kind,
    RefusedError,
    Track,
    Transport,
    ends_with_next,
    find_tracks,
    has_own_clock,
    is_live,
    is_network,
    is_one_picture,
    live_dating,
    open_container,
    shown_name,
)
from wax.capture.file.not_opened import stopped
from wax.capture.stream_dating import Dating, Repeats
from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

    from av.container import InputContainer
    from av.packet import Packet

    from wax.clock import Clock

_LOG = structlog.get_logger(__name__)

_START_S: Final = 0.2
"""The time from opening a file to its first picture, so that it is decoded before it is due."""

_AHEAD_S: Final = 0.5
_AHEAD_STARVED_S: Final = 10.0
"""How far to read ahead, normally and while one stream lags behind the other in a file."""

_KEPT_S: Final = 2.0
"""An unread queue is cleared when it holds this much more than the read-ahead."""

_PATIENCE_S: Final = 2.0
_REBUFFER_S: Final = 0.5
_STALL_S: Final = 1.0
_SHORTEST_PASS_S: Final = 0.02
_PICTURE_BY_PICTURE: Final = frozenset({"mjpeg", "jpeg2000", "png"})
"""Codecs whose equal packets decode to equal pictures."""


@dataclass(frozen=True, slots=True)
class Coded:
    """A packet for its decoder, due at `due_s`; `zero_s` is the stream's time 0.

    `within_s` is the error bound of its time of capture, None if that is unknown. A packet of
    another track than the previous packet's begins a new pass.
    """

    packet: Packet[Any]
    track: Track
    zero_s: float
    due_s: float
    within_s: float | None


@dataclass(slots=True)
class _Queue:
    items: deque[Coded] = field(default_factory=deque)
    needed_s: float | None = None
    """While a reader waits: how far to read ahead before it learns that nothing is due.

    A reader whose queue has an item no longer counts as waiting, even before it wakes; otherwise
    the other stream would be read so far ahead that its queue is cleared.
    """
    resume_s: float | None = float("-inf")
    """While not None, everything before a keyframe due at or after this time is dropped."""

    def put(self, item: Coded, longest_s: float) -> None:
        if self.items and item.due_s - self.items[0].due_s > longest_s:
            self.items.clear()
            self.resume_s = item.due_s
        if self.resume_s is not None:
            if not item.packet.is_keyframe or item.due_s < self.resume_s:
                return
            self.resume_s = None
        self.items.append(item)


class Demuxer:
    """Reads `address` until `stop` or a failure; it cannot be restarted.

    `wanted` are the streams that will be read.
    """

    def __init__(
        self,
        address: str,
        clock: Clock,
        wanted: frozenset[Kind],
        transport: Transport = "auto",
    ) -> None:
        self._address = address
        self._transport = transport
        self.delivered = False
        """Whether any packet has arrived."""
        self.name = shown_name(address)
        self.live = False
        self._network = is_network(address)
        self._clock = clock
        self._queues: dict[Kind, _Queue] = {kind: _Queue() for kind in wanted}
        self._condition = threading.Condition()
        self._zero_s: float | None = None
        self._within_s: float | None = None
        self._recorded = False
        self._ends_with_next = False
        self._handed_s: dict[int, float] = {}
        self._dating = Dating(stamped=False)
        self._repeats = Repeats()
        self._horizon_s = float("-inf")
        self._found: frozenset[Kind] | None = None
        self._failure: SourceError | None = None
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="demux", daemon=True)

    @property
    def failed(self) -> bool:
        return self._failure is not None

    @property
    def failure(self) -> SourceError | None:
        """Why the thread has ended, if it has."""
        return self._failure

    @property
    def refused(self) -> bool:
        """Whether the address refused the user name or password."""
        return isinstance(self._failure, RefusedError)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """End the thread, which takes a few seconds while it waits for the network."""
        with self._condition:
            self._stopping = True
            self._condition.notify_all()
        self._thread.join(timeout=0.5)

    def kinds(self) -> frozenset[Kind]:
        """Wait until the address is open and return its tracks; raises `SourceError`."""
        with self._condition:
            self._condition.wait_for(lambda: self._found is not None or self.failed, timeout=8)
            if self._found is not None:
                return self._found
            raise self._failure or SourceError(Sentence("file.silent", {"name": self.name}))

    def next_packet(self, kind: Kind, until_s: float) -> Coded | None:
        """Return the next packet; None if none is due before `until_s`.

        Blocks at most 2 s; raises `SourceError`.
        """
        far_s = until_s + (_AHEAD_S if self._network else _AHEAD_STARVED_S)
        with self._condition:
            queue = self._queues[kind]
            queue.needed_s = far_s
            self._condition.notify_all()
            self._condition.wait_for(
                lambda: queue.items or self.failed or self._horizon_s > far_s, _PATIENCE_S
            )
            queue.needed_s = None
            if queue.items:
                self._condition.notify_all()
                return queue.items.popleft()
            if self._failure is not None:
                raise self._failure
            if self._horizon_s > far_s:
                return None
            raise SourceError(Sentence("file.silent", {"name": self.name}))

    def waiting(self, kind: Kind) -> int:
        """Return how many packets `next_packet` can return without waiting."""
        with self._condition:
            return len(self._queues[kind].items)

    def skip_to_keyframe(self, kind: Kind, due_s: float) -> None:
        """Drop every packet before a keyframe that is due at or after `due_s`."""
        with self._condition:
            waiting = self._queues[kind].items
            queue = self._queues[kind] = _Queue(resume_s=due_s)
            for item in waiting:
                queue.put(item, float("inf"))
            self._condition.notify_all()

    def skip_to_newest_keyframe(self, kind: Kind) -> bool:
        """Drop what precedes the newest keyframe that is due; return whether anything did."""
        with self._condition:
            items, now_s = self._queues[kind].items, self._clock.now_s()
            due = (at for at, one in enumerate(items) if one.due_s <= now_s)
            newest = max((at for at in due if items[at].packet.is_keyframe), default=0)
            for _ in range(newest):
                items.popleft()
            self._condition.notify_all()
        return newest > 0

    def _run(self) -> None:
        failure = SourceError(Sentence("file.closed", {"name": self.name}))
        try:
            start_s: float | None = None
            while not self._stopping:
                start_s = self._play(start_s)
        except SourceError as error:
            failure = error
        except FFmpegError as error:
            failure = SourceError(stopped(self.name, error))
        except Exception as error:
            # The error's own text may contain the address with its password.
            why = type(error).__name__ if self._network else str(error)
            _LOG.error("demuxer failed", address=self.name, why=why)
            failure = SourceError(Sentence("file.failed", {"name": self.name, "why": why}))
        with self._condition:
            self._failure = failure
            self._condition.notify_all()

    def _play(self, start_s: float | None) -> float:
        """Play the address once; return the start time of the next pass."""
        with open_container(self._address, self._transport) as container:
            found = find_tracks(container)
            self.live = is_live(self._address, container)
            self._dating = live_dating(self._address, container, self._transport)
            self._repeats = Repeats()
            self._ends_with_next, self._handed_s = ends_with_next(container), {}
            # A recorder's recording is of unknown age even if it arrives like a live stream.
            self._recorded = container.duration is not None
            self._within_s = 0.0 if has_own_clock(self._address, container) else None
            with self._condition:
                self._found = frozenset(found)
                self._condition.notify_all()
            tracks = {track.index: track for kind, track in found.items() if kind in self._queues}
            if not tracks:
                raise SourceError(Sentence("file.neither", {"name": self.name}))
            now_s = self._clock.now_s()
            if start_s is None or start_s < now_s - _STALL_S:
                start_s = now_s + _START_S
            origin_s = (container.start_time or 0) / 1e6
            self._zero_s = None if self.live else start_s - origin_s
            ends_s = dict.fromkeys(tracks, origin_s)
            for packet in self._packets(container, list(tracks)):
                self._put(packet, tracks[packet.stream_index], ends_s, container.duration)
            length_s = max(ends_s.values()) - origin_s
            # Rebuffering may have shifted a segmented stream's timeline meanwhile.
            start_s = start_s if self._zero_s is None else self._zero_s + origin_s
            return start_s + _pass_length_s(length_s, container.duration)

    def _packets(self, container: InputContainer, indices: list[int]) -> Iterator[Packet[Any]]:
        """Yield packets no faster than needed; a truncated file simply ends."""
        count = 0
        try:
            for packet in container.demux([container.streams[index] for index in indices]):
                if not self._wait_until_needed():
                    return
                if packet.size:
                    count += 1
                    yield packet
        except FFmpegError as error:
            # A snapshot without a length ends when its connection does.
            if not count or (self._network and not is_one_picture(container)):
                raise
            _LOG.warning("file is damaged; played as far as possible", file=self.name, why=error)
        if self.live:
            raise SourceError(Sentence("file.over", {"name": self.name}))
        if not count:
            raise SourceError(Sentence("file.empty", {"name": self.name}))

    def _wait_until_needed(self) -> bool:
        with self._condition:
            while not self._stopping:
                waits = (queue for queue in self._queues.values() if not queue.items)
                needed_s = max((queue.needed_s or 0.0 for queue in waits), default=0.0)
                far_s = max(self._clock.now_s() + _AHEAD_S, needed_s)
                if self.live or self._horizon_s <= far_s:
                    return True
                self._condition.wait(0.05)
        return False

    def _put(
        self,
        packet: Packet[Any],
        track: Track,
        ends_s: dict[int, float],
        duration_us: int | None,
    ) -> None:
        """Map a packet to the timeline and queue it."""
        time_base = packet.time_base
        stamp = packet.pts if packet.pts is not None else packet.dts
        decoded_s = None if packet.dts is None else float(packet.dts * time_base)
        if stamp is None:
            # A bare elementary stream has no timestamps: count packets.
            stamp = packet.dts = round(ends_s[track.index] / time_base)
        time_s = float(stamp * time_base)
        if duration_us and not self.live and time_s > ends_s[track.index] + duration_us / 1e6 + 1:
            return  # damaged: this packet would never be due
        length_s = float((packet.duration or 0) * time_base) or track.period_s
        ends_s[track.index] = max(ends_s[track.index], time_s + length_s)
        now_s = self._clock.now_s()
        with self._condition:
            self.delivered = True
            if self.live:
                repeats = self._repeated(packet, track, now_s)
                if repeats == "again":
                    return
                came_s = self._arrival_s(track, now_s)
                zero_s, within_s = self._dating.date(track.index, time_s, decoded_s, came_s)
                if repeats == "old" or self._recorded:
                    within_s = None
                due_s = now_s
            else:
                zero_s, within_s = self._follow(time_s, now_s), self._within_s
                due_s = zero_s + time_s
            longest_s = _KEPT_S + (0 if self.live else _AHEAD_STARVED_S)
            self._queues[track.kind].put(Coded(packet, track, zero_s, due_s, within_s), longest_s)
            self._horizon_s = max(self._horizon_s, due_s)
            self._condition.notify_all()

    def _follow(self, time_s: float, now_s: float) -> float:
        """Return when a paced stream's time 0 is, shifted if the network is too slow."""
        arrived_s = now_s - time_s
        if self._zero_s is None:
            self._zero_s = arrived_s
        late_s = arrived_s - self._zero_s
        if self._network and late_s > _REBUFFER_S:
            self._zero_s += late_s + _REBUFFER_S
        return self._zero_s

    def _arrival_s(self, track: Track, now_s: float) -> float:
        """Return when a packet arrived: at the last one's hand-over if the next packet ends it."""
        before_s = self._handed_s.get(track.index, now_s)
        self._handed_s[track.index] = now_s
        return before_s if self._ends_with_next and track.kind == "video" else now_s

    def _repeated(
        self, packet: Packet[Any], track: Track, now_s: float
    ) -> Literal["new", "again", "old"]:
        if track.kind != "video" or track.decoder.name not in _PICTURE_BY_PICTURE:
            return "new"
        return self._repeats.of(bytes(packet), now_s)


def _pass_length_s(length_s: float, duration_us: int | None) -> float:
    """Return the length of a pass that read packets for `length_s`.

    The container's duration is more exact, because the decoder removes the last packet's padding.
    It counts only if it is close, because it may be a guess, or too long for a truncated file.
    """
    if duration_us and 0 <= length_s - duration_us / 1e6 < 0.1:
        length_s = duration_us / 1e6
    return max(length_s, _SHORTEST_PASS_S)
