"""Estimates when a live stream's pictures were captured, from time stamps and arrival. Pure.

The arrival on our own clock is the only time that no sender can make up. Where the container has
time stamps, they add how much later than others a picture arrives: one that was queued on its way
is old, though it has only just arrived. No picture counts as captured after its arrival. The delay
between the sensor and the fastest arrival so far (exposure, encoding, transfer) cannot be measured
here; `LIVE_WITHIN_S` bounds it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from statistics import median
from typing import Final, Literal

LIVE_WITHIN_S: Final = 0.2
"""The delay of common network cameras from the sensor to the arrival of the first bit."""

_SETTLE_S: Final = 1.0
"""The first pictures may be old: servers keep the last one, or a second of them, for newcomers."""

_JUMP_S: Final = 0.5
"""A picture whose lateness is this much below that of the last one proves a jump of the stamps."""

_JITTERED: Final = 8
_LOST_S: Final = 2.0
_FOUND_S: Final = 0.1
_NEVER_S: Final = 10.0
"""Stamps that fall this far behind come from another clock, or from a backlog too old to drive by;
they count again once they have caught up."""

_REPEATED_S: Final = 1.0

_WINDOW_S: Final = 5.0
_WINDOWS: Final = 9
_FEWEST: Final = 3
_MOST_DRIFT: Final = 0.005
_FORGET: Final = 0.0005
"""A sender's clock may run slow by 0.5 %, as some cameras' do, at one rate in most 5 s windows.
A delay that appears once and stays is real, so it is forgotten by only 30 ms a minute."""


@dataclass(slots=True)
class _Track:
    """One track's stamps: `offset_s` is the sum of their jumps, `before_s` the sum before the last.

    `lates_s` is how late its newest packets were: the minimum is backlog, the rest is jitter.
    """

    offset_s: float
    before_s: float
    decoded_s: float
    arrived_s: float
    lates_s: deque[float] = field(default_factory=lambda: deque([0.0], maxlen=_JITTERED))
    jumped: bool = False


class Dating:
    """Dates one opened stream; `stamped` is whether its container has a clock at all.

    `queues` is whether the transport may queue what the link cannot carry, as TCP does. No datagram
    arrives 10 s late, so without a queue stamps that claim this are ignored from then on, and
    arrival alone counts.
    """

    def __init__(self, *, stamped: bool, queues: bool = True) -> None:
        self._stamped = stamped
        self._queues = queues
        self._first_s: float | None = None
        self._before_s = 0.0
        self._zero_s = 0.0
        self._tracks: dict[int, _Track] = {}
        self._lost = False
        self._floor_s: float | None = None
        self._ended: tuple[float, float] | None = None
        self._slopes: deque[float] = deque(maxlen=_WINDOWS)
        self._window_s = 0.0

    def date(
        self, track: int, shown_s: float, decoded_s: float | None, arrived_s: float
    ) -> tuple[float, float | None]:
        """Return when the stream's time 0 was, and that time's error bound (None: unknown).

        `shown_s` is a packet's presentation stamp: it was captured that much after time 0.
        `decoded_s` is its decoding stamp, which rises from packet to packet; None if it has none.
        Within a track `arrived_s` never falls.
        """
        if self._first_s is None:
            self._first_s = self._before_s = self._window_s = arrived_s
            self._zero_s = arrived_s - shown_s
        if self._stamped:
            zero_s = self._follow(track, shown_s, decoded_s, arrived_s)
        else:
            zero_s = arrived_s - shown_s
        self._before_s = arrived_s
        is_known = arrived_s - self._first_s >= _SETTLE_S and not self._lost
        return zero_s, LIVE_WITHIN_S if is_known else None

    def _follow(
        self, number: int, shown_s: float, decoded_s: float | None, arrived_s: float
    ) -> float:
        self._zero_s += (self._drift() + _FORGET) * (arrived_s - self._before_s)
        stamp_s = shown_s if decoded_s is None else decoded_s
        track = self._tracks.get(number)
        if track is None:
            offset_s = next((one.offset_s for one in self._tracks.values()), 0.0)
            track = self._tracks[number] = _Track(offset_s, offset_s, stamp_s, arrived_s)
        elif decoded_s is None or self._has_jumped(track, stamp_s, arrived_s):
            self._jump(track, shown_s, arrived_s)
            track.jumped = True
        else:
            track.jumped = False
        track.decoded_s, track.arrived_s = stamp_s, arrived_s
        way_s = arrived_s - (shown_s - track.offset_s)
        self._zero_s = min(self._zero_s, way_s)
        late_s = way_s - self._zero_s
        track.lates_s.append(late_s)
        self._measure(way_s, arrived_s)
        self._lost = late_s > (_FOUND_S if self._lost else _LOST_S)
        if not self._queues and late_s > _NEVER_S:
            self._stamped = self._lost = False
        counts = self._stamped and not self._lost
        return (self._zero_s if counts else way_s) - track.offset_s

    @staticmethod
    def _has_jumped(track: _Track, stamp_s: float, arrived_s: float) -> bool:
        """Return whether stamps stay, go back, or gain more than a drained backlog explains."""
        step_s = stamp_s - track.decoded_s
        return step_s <= 0.0 or step_s - (arrived_s - track.arrived_s) > track.lates_s[-1] + _JUMP_S

    def _jump(self, track: _Track, shown_s: float, arrived_s: float) -> None:
        """Absorb a jump into the offset: a return to the one before, or to that of another track.

        It is no return if the packet would then be later than any recent one. Otherwise the packet
        counts as late as before the jump, or, after several jumps in a row, less late each time,
        because a backlog drains.
        """
        offset_s, most_s = track.offset_s, max(track.lates_s)
        for known_s in (track.before_s, *(other.offset_s for other in self._tracks.values())):
            late_s = arrived_s - (shown_s - known_s) - self._zero_s
            if abs(known_s - offset_s) > _JUMP_S and -_JUMP_S < late_s <= most_s:
                track.before_s, track.offset_s = offset_s, known_s
                return
        track.before_s = offset_s
        passed_s = arrived_s - track.arrived_s if track.jumped else 0.0
        late_s = max(0.0, min(*track.lates_s, _LOST_S) - passed_s)
        track.offset_s = shown_s - (arrived_s - self._zero_s - late_s)

    def _measure(self, way_s: float, arrived_s: float) -> None:
        """Record how fast the shortest delay grows from window to window."""
        self._floor_s = way_s if self._floor_s is None else min(self._floor_s, way_s)
        if arrived_s - self._window_s < _WINDOW_S:
            return
        if self._ended is not None:
            floor_s, at_s = self._ended
            self._slopes.append((self._floor_s - floor_s) / (arrived_s - at_s))
        self._ended = self._floor_s, arrived_s
        self._floor_s, self._window_s = None, arrived_s

    def _drift(self) -> float:
        """Return how fast the sender's clock falls behind: the median over the windows."""
        if len(self._slopes) < _FEWEST:
            return 0.0
        return min(max(median(self._slopes), 0.0), _MOST_DRIFT)


class Repeats:
    """Detects repeated pictures, which no sensor produces: its noise differs each time.

    Servers repeat the last picture while their camera hangs or is gone.
    """

    def __init__(self) -> None:
        self._content = b""
        self._since_s = 0.0

    def of(self, content: bytes, now_s: float) -> Literal["new", "again", "old"]:
        """Compare with the last picture: ``again`` may be dropped, ``old`` has repeated for 1 s.

        A server that sends at a higher rate than its camera's repeats every picture.
        """
        if content != self._content:
            self._content, self._since_s = content, now_s
            return "new"
        return "again" if now_s - self._since_s < _REPEATED_S else "old"
