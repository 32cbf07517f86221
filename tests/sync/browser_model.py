"""A model of a browser's playout without a clock: NetEq and the video jitter buffer.

The sound's buffer targets what 95 of 100 packets of the last 2 s need, or the given minimum, and is
stretched by 75 ms a second to get there; a unit that has not arrived when it is due is concealed. A
picture is shown when it and its references are complete, and not before its hold-back.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from wax.sync.playout import PlayoutReport, StreamPlayout

_NETEQ_QUANTILE = 0.95
_NETEQ_PACKETS = 100
_STRETCH_PER_S = 0.075
_FLOOR_S = 10.0
_FAR_S = 1.0


@dataclass(slots=True)
class _Unit:
    sent_s: float
    mu_s: float
    arrived_s: float = math.inf


class _Floor:
    """The minimum delay of the last seconds."""

    def __init__(self) -> None:
        self._rising: deque[tuple[float, float]] = deque()

    def add(self, at_s: float, delay_s: float) -> float:
        while self._rising and self._rising[-1][1] >= delay_s:
            self._rising.pop()
        self._rising.append((at_s, delay_s))
        while self._rising[0][0] < at_s - _FLOOR_S:
            self._rising.popleft()
        return self._rising[0][1]

    @property
    def delay_s(self) -> float | None:
        return self._rising[0][1] if self._rising else None


class SoundBuffer:
    """Receives every packet; call `play` as time passes."""

    def __init__(self) -> None:
        self.delay_s = 0.04
        self.least_s = 0.0
        self.concealed_s = self.played_s = 0.0
        self._floor = _Floor()
        self._late: deque[float] = deque(maxlen=_NETEQ_PACKETS)
        self._units: deque[_Unit] = deque()
        self._by_number: dict[int, _Unit] = {}
        self._now_s: float | None = None

    def sent(self, number: int, sent_s: float, mu_s: float) -> None:
        """Expect a unit, as a gap in the sequence numbers would make a browser do later."""
        unit = _Unit(sent_s, mu_s)
        self._units.append(unit)
        self._by_number[number] = unit

    def came(self, number: int, redundancy: int, now_s: float) -> None:
        unit = self._by_number.get(number)
        if unit is not None:
            late_s = now_s - unit.sent_s - self._floor.add(now_s, now_s - unit.sent_s)
            self._late.append(late_s)
        for at in range(number - redundancy, number + 1):
            again = self._by_number.get(at)
            if again is not None:
                again.arrived_s = min(again.arrived_s, now_s)

    @property
    def age_s(self) -> float:
        """The delay from capture to ear, without the device."""
        return (self._floor.delay_s or 0.0) + self.delay_s

    def play(self, now_s: float) -> None:
        """Play what is due by now."""
        elapsed_s = 0.0 if self._now_s is None else now_s - self._now_s
        self._now_s = now_s
        floor_s = self._floor.delay_s
        if floor_s is None:
            self._drop_before(now_s - _FAR_S)
            return
        late = sorted(self._late)
        neteq_s = late[int(_NETEQ_QUANTILE * (len(late) - 1))] if late else 0.0
        target_s = max(self.least_s, neteq_s, self._units[0].mu_s if self._units else 0.02)
        step_s = _STRETCH_PER_S * elapsed_s
        self.delay_s += min(max(target_s - self.delay_s, -step_s), step_s)
        while self._units and self._units[0].sent_s + floor_s + self.delay_s <= now_s:
            unit = self._units.popleft()
            self.played_s += unit.mu_s
            if unit.arrived_s > unit.sent_s + floor_s + self.delay_s:
                self.concealed_s += unit.mu_s
        self._drop_before(now_s - 4 * _FAR_S, played=True)

    def _drop_before(self, sent_s: float, *, played: bool = False) -> None:
        while not played and self._units and self._units[0].sent_s < sent_s:
            self._units.popleft()
        while self._by_number:
            first = next(iter(self._by_number))
            if self._by_number[first].sent_s >= sent_s:
                return
            del self._by_number[first]


@dataclass(slots=True)
class _Frame:
    captured_s: float
    left: int
    before: int | None
    complete_s: float = math.inf


class PictureBuffer:
    """Receives every packet; a picture is shown once its references are complete."""

    def __init__(self) -> None:
        self.hold_s = 0.0
        self.shown: deque[tuple[float, float]] = deque()
        """When each was shown lately, and how old it was then."""
        self._floor = _Floor()
        self._frames: dict[int, _Frame] = {}

    def sent(self, number: int, captured_s: float, packets: int, before: int | None) -> None:
        self._frames[number] = _Frame(captured_s, packets, before)
        while len(self._frames) > 256:
            del self._frames[next(iter(self._frames))]

    def came(self, number: int, now_s: float) -> list[tuple[float, float]]:
        """Return the capture times of the pictures that are shown because of this packet."""
        frame = self._frames.get(number)
        if frame is None:
            return []
        frame.left -= 1
        if frame.left > 0:
            return []
        out = []
        for at in sorted(self._frames):
            if at >= number and self._frames[at].complete_s == math.inf:
                one = self._frames[at]
                before = None if one.before is None else self._frames.get(one.before)
                if one.left <= 0 and (before is None or before.complete_s <= now_s):
                    one.complete_s = now_s
                    out.append(self._show(one, now_s))
        self.shown.extend((shown_s, shown_s - captured_s) for captured_s, shown_s in out)
        return out

    def _show(self, frame: _Frame, now_s: float) -> tuple[float, float]:
        floor_s = self._floor.add(now_s, now_s - frame.captured_s)
        shown_s = max(now_s, frame.captured_s + floor_s + self.hold_s)
        return frame.captured_s, shown_s

    def age_s(self, from_s: float, until_s: float) -> float | None:
        while self.shown and self.shown[0][0] < from_s:
            self.shown.popleft()
        ages = [age_s for at_s, age_s in self.shown if at_s < until_s]
        return sum(ages) / len(ages) if ages else None


class Browser:
    """Both buffers, and the page's report of them."""

    def __init__(self) -> None:
        self.sound = SoundBuffer()
        self.picture = PictureBuffer()

    def report(self, now_s: float, *, sees: bool) -> PlayoutReport:
        self.sound.play(now_s)
        age_s = self.picture.age_s(now_s - 0.25, now_s)
        picture = StreamPlayout(
            age_ms=None if age_s is None else age_s * 1000, delay_ms=self.picture.hold_s * 1000
        )
        sound = StreamPlayout(
            age_ms=self.sound.age_s * 1000,
            delay_ms=self.sound.delay_s * 1000,
            concealed_ms=self.sound.concealed_s * 1000,
            played_ms=self.sound.played_s * 1000,
        )
        return PlayoutReport(sound=sound, picture=picture if sees else None)
