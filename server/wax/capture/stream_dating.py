"""When the pictures of a live stream were captured, from their time stamps and their arrival. Pure.

Arrival on our own clock is the only clock that nobody can invent. Where the container has time
stamps, they add how much later than others a picture comes: what waited on its way is old, though
it has only just arrived. Nothing counts as captured after its arrival. What lies between the sensor
and the shortest way so far (exposure, encoding, transfer) is not seen from here; `LIVE_WITHIN_S`
stands for it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from statistics import median
from typing import Final, Literal

LIVE_WITHIN_S: Final = 0.2
"""What network cameras commonly need from the sensor to the first bit here."""

_SETTLE_S: Final = 1.0
"""What comes first may be old: servers keep the last picture, or a second, for newcomers."""

_JUMP_S: Final = 0.5
"""A picture can be this much less late than the last one only if the stamps have jumped."""

_JITTERED: Final = 8
_LOST_S: Final = 2.0
_FOUND_S: Final = 0.1
_NEVER_S: Final = 10.0
"""Stamps that fall this far behind are those of another clock, or of a jam that nobody drives by;
they count again when they are back."""

_REPEATED_S: Final = 1.0

_WINDOW_S: Final = 5.0
_WINDOWS: Final = 9
_FEWEST: Final = 3
_MOST_DRIFT: Final = 0.005
_FORGET: Final = 0.0005
"""A sender's clock may run slow by 0.5 %, as some cameras' do: by the same in most windows of 5 s.
A delay that comes once and stays is forgotten by 30 ms a minute only: it is real."""


@dataclass(slots=True)
class _Track:
    """`offset_s` is what its stamps have jumped, `before_s` what they had before the last jump.

    `lates_s` is how late its newest packets were: their least is a jam, the rest is jitter.
    """

    offset_s: float
    before_s: float
    decoded_s: float
    arrived_s: float
    lates_s: deque[float] = field(default_factory=lambda: deque([0.0], maxlen=_JITTERED))
    jumped: bool = False


class Dating:
    """One opened stream; `stamped` is whether its container has a clock at all.

    `queues` is whether the way may keep what it cannot carry, as TCP does: by datagrams nothing
    comes 10 s late, so stamps that say so are given up, and arrival alone counts.
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
        """Return when the stream's time 0 was, and within what that is certain (None: unknown).

        `shown_s` is the stamp of a packet, which was captured that much after time 0; `decoded_s`
        rises from packet to packet, None where the packet has no stamp. Within a track `arrived_s`
        never falls.
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
        """Whether stamps stand, run backwards, or are ahead of what any jam can make up for."""
        step_s = stamp_s - track.decoded_s
        return step_s <= 0.0 or step_s - (arrived_s - track.arrived_s) > track.lates_s[-1] + _JUMP_S

    def _jump(self, track: _Track, shown_s: float, arrived_s: float) -> None:
        """Absorb a jump: back to where it was, or by as much as another track of the same clock.

        Else it is as late as before; where jump follows jump, less each time, for a jam passes.
        What would be later than anything lately has not come back: that is another jump.
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
        """Note by how much the shortest way of each window grows."""
        self._floor_s = way_s if self._floor_s is None else min(self._floor_s, way_s)
        if arrived_s - self._window_s < _WINDOW_S:
            return
        if self._ended is not None:
            floor_s, at_s = self._ended
            self._slopes.append((self._floor_s - floor_s) / (arrived_s - at_s))
        self._ended = self._floor_s, arrived_s
        self._floor_s, self._window_s = None, arrived_s

    def _drift(self) -> float:
        """Return how fast the sender's clock falls behind: in most windows, not in one."""
        if len(self._slopes) < _FEWEST:
            return 0.0
        return min(max(median(self._slopes), 0.0), _MOST_DRIFT)


class Repeats:
    """Tells a picture from its repetitions, which no sensor makes: its noise differs each time.

    Servers repeat the last picture while their camera stands still or has gone.
    """

    def __init__(self) -> None:
        self._content = b""
        self._since_s = 0.0

    def of(self, content: bytes, now_s: float) -> Literal["new", "again", "old"]:
        """Compare with the picture before: ``again`` may be left out, ``old`` comes for a second.

        A server that sends more often than its camera takes pictures repeats each of them.
        """
        if content != self._content:
            self._content, self._since_s = content, now_s
            return "new"
        return "again" if now_s - self._since_s < _REPEATED_S else "old"
