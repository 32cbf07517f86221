"""Decides what a frame of an episode holds: its picture, its action, its observation. Pure.

A frame's time is the capture of its picture. Its action is the set-point in force at that time, its
observation what the robot had reported last.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Generic, TypeVar

from wax.control.gate import LAPSE_S
from wax.protocol.robot_report import ROBOT_VALUES
from wax.protocol.tape_events import Commanded, Reported, Steered

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from wax.protocol.tape_events import TapeEvent

_Picture = TypeVar("_Picture")
_Event = TypeVar("_Event")

ACTIONS: Final = ("linear_mps", "angular_rps", "lateral_mps")
"""The fields of a set-point that are actions."""
AXIS: Final = "axis."
CONTROL: Final = "control."
GAUGE: Final = "gauge."
"""What the names of axes and controls, among the actions, and of gauges, among the observations,
begin with."""
OBSERVED: Final = ("moving", "x_m", "y_m", "heading_rad", *ROBOT_VALUES)
"""The fields of a report that are observations, as far as the robot reports them."""

PASSED, SLOWED, HELD_BACK = 0, 1, 2
"""What the gate did: it let the command pass, slowed the robot, or held it."""


class Grid(Generic[_Picture]):
    """Samples pictures at a constant rate: each frame gets the picture captured nearest to it.

    Frame 0 is at the first picture. A picture that is half a frame late is missing: its frame
    repeats the previous one.
    """

    def __init__(self, fps: float) -> None:
        self._fps = fps
        self._first_s = math.nan
        self._frames = 0
        self._newest: tuple[float, _Picture] | None = None

    def add(self, captured_s: float, picture: _Picture) -> Iterator[tuple[float, _Picture]]:
        """Yield the frames that are due before this picture; captures must not go back."""
        before, self._newest = self._newest, (captured_s, picture)
        if before is None:
            self._first_s = captured_s
            return
        until_s = max((before[0] + captured_s) / 2, captured_s - 0.5 / self._fps)
        while self._due_s <= until_s:
            self._frames += 1
            yield before

    def finish(self) -> Iterator[tuple[float, _Picture]]:
        """Yield the last frame, if one is due at the last picture."""
        if self._newest is not None and self._due_s <= self._newest[0] + 0.5 / self._fps:
            self._frames += 1
            yield self._newest

    @property
    def _due_s(self) -> float:
        return self._first_s + self._frames / self._fps


def are_on_grid(times_s: Sequence[float], fps: float) -> bool:
    """Whether the grid takes each picture once, so that they can be copied."""
    grid: Grid[None] = Grid(fps)
    frames = [frame_s for at_s in times_s for frame_s, _ in grid.add(at_s, None)]
    return [*frames, *(frame_s for frame_s, _ in grid.finish())] == list(times_s)


@dataclass(frozen=True, slots=True)
class DatasetFrame:
    """One row of the dataset; its picture was captured at `captured_s` since 1970.

    `observed` has the values of `Timeline`'s names.
    """

    captured_s: float
    action: tuple[float, ...]
    observed: tuple[float, ...]
    gate: int
    held: bool

    def acting_as(self, other: DatasetFrame) -> DatasetFrame:
        """Return this frame with another's action."""
        return replace(self, action=other.action)


@dataclass(slots=True)
class _History(Generic[_Event]):
    """Events of one kind, in order of time."""

    times_s: list[float] = field(default_factory=list)
    events: list[_Event] = field(default_factory=list)

    def add(self, at_s: float, event: _Event) -> None:
        self.times_s.append(at_s)
        self.events.append(event)

    def at(self, now_s: float) -> _Event | None:
        number = bisect_right(self.times_s, now_s)
        return self.events[number - 1] if number else None


class Timeline:
    """The events of a span of time, which come in order; `observed` names the observations."""

    def __init__(
        self,
        events: Iterable[tuple[float, TapeEvent]],
        *,
        actions: Sequence[str],
        observed: Sequence[str],
    ) -> None:
        self._actions, self._observed = actions, observed
        self._steered: _History[Steered] = _History()
        self._reported: _History[tuple[float, ...]] = _History()
        self._commanded: _History[Commanded] = _History()
        known = dict.fromkeys(observed, math.nan)
        for at_s, event in events:
            match event:
                case Steered():
                    self._steered.add(at_s, event)
                case Reported():
                    values = told(event)
                    known |= {name: values[name] for name in known.keys() & values.keys()}
                    self._reported.add(at_s, tuple(known.values()))
                case Commanded() if event.refused not in _NOT_THE_OPERATORS:
                    self._commanded.add(at_s, event)

    def frame(self, captured_s: float) -> DatasetFrame | None:
        """Return the frame of a picture; None while an action or observation is unknown."""
        steered = self._steered.at(captured_s)
        observed = self._reported.at(captured_s) if self._observed else ()
        if steered is None or observed is None or any(map(math.isnan, observed)):
            return None
        return DatasetFrame(
            captured_s=captured_s,
            action=tuple(_action(steered, name) for name in self._actions),
            observed=observed,
            gate=_gate(steered),
            held=self._is_held(captured_s),
        )

    def _is_held(self, now_s: float) -> bool:
        number = bisect_right(self._commanded.times_s, now_s)
        if not number or now_s - self._commanded.times_s[number - 1] > LAPSE_S:
            return False
        newest = self._commanded.events[number - 1]
        return newest.held or any((newest.linear, newest.angular, newest.lateral, newest.axes))


def _gate(steered: Steered) -> int:
    if steered.reason is not None:
        return HELD_BACK
    return PASSED if steered.limit is None else SLOWED


_NOT_THE_OPERATORS: Final = ("not_your_turn", "other_turn")


def told(report: Reported) -> dict[str, float]:
    """Return the observations that a report has."""
    values = ((name, getattr(report, name)) for name in OBSERVED)
    found = {name: float(value) for name, value in values if value is not None}
    return found | {GAUGE + name: value for name, value in report.gauges.items()}


def named(steered: Steered) -> dict[str, float]:
    """Return the axes and controls of a set-point by the names of their actions."""
    axes = {AXIS + name: value for name, value in steered.axes.items()}
    return axes | {CONTROL + name: value for name, value in steered.controls.items()}


def _action(steered: Steered, name: str) -> float:
    if name in ACTIONS:
        value: float = getattr(steered, name)
        return value
    return named(steered).get(name, 0.0)
