"""Events for what has changed between two polls by `app.py`; debounces faults. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal

from wax.protocol.events import (
    ClusterEvent,
    DoorEvent,
    Event,
    FaultEvent,
    Part,
    QueueEvent,
    TunnelEvent,
)
from wax.session import equipment

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from wax.config.controls import GaugeSettings
    from wax.driver.interface import RobotState
    from wax.sentence import Sentence

BEGAN_S: Final = 3.0
"""A shorter fault is not worth a message."""
MENDED_S: Final = 10.0
"""A loose plug is one fault, not one a second."""
LOW: Final = 0.15
CHARGED: Final = 0.2

Fault = tuple[Part | Literal["room", "tunnel"], str | None]
"""The failed part, and its name where there are several."""

_ROBOT: Final[Fault] = ("robot", None)
_BATTERY: Final[Fault] = ("battery", None)
_TOLD_BY_ROBOT: Final = ("battery", "gauge")


@dataclass(frozen=True, slots=True)
class StateSeen:
    """The state at one poll; `faults` has a short reason for each."""

    is_open: bool
    waiting: int
    faults: Mapping[Fault, str] = field(default_factory=dict)
    battery_fraction: float | None = None


def faults(
    problems: Mapping[Fault, Sentence | None],
    state: RobotState,
    gauges: Iterable[GaugeSettings],
    lost_rooms: Iterable[int],
    tunnel: Sentence | None = None,
) -> dict[Fault, str]:
    """Return the faults: `problems` that are not None, the robot, its gauges, rooms, tunnel."""
    found = {fault: _code(problem) for fault, problem in problems.items() if problem is not None}
    found |= {("room", str(number)): "lost" for number in lost_rooms}
    if tunnel is not None:
        found["tunnel", None] = _code(tunnel)
    if state.said is not None or not state.connected:
        found[_ROBOT] = _code(state.said) if state.said else "robot.not_connected"
    for name, level in equipment.beyond(gauges, state).items():
        found["gauge", name] = level
    return found


@dataclass(slots=True)
class _Followed:
    began_s: float
    ill_s: float
    why: str = ""
    is_told: bool = False


class Changes:
    """Remembers the previous poll; the first one says whether visitors are let in."""

    def __init__(self) -> None:
        self._is_open: bool | None = None
        self._waits = False
        self._followed: dict[Fault, _Followed] = {}

    def compare(self, seen: StateSeen, now_s: float) -> Iterator[Event]:
        """Yield what has changed."""
        if seen.is_open != self._is_open:
            self._is_open = seen.is_open
            yield DoorEvent(type="door.opened" if seen.is_open else "door.closed")
        if (seen.waiting > 0) != self._waits:
            self._waits = seen.waiting > 0
            yield QueueEvent(type="queue.waiting" if self._waits else "queue.empty")
        ill = dict(seen.faults)
        if self._is_low(seen.battery_fraction):
            ill[_BATTERY] = "low"
        for fault in {**self._followed, **ill}:
            # A robot that is not connected reports no battery, which does not mend it.
            if _ROBOT not in ill or fault[0] not in _TOLD_BY_ROBOT:
                yield from self._follow(fault, ill.get(fault), now_s)

    def _is_low(self, fraction: float | None) -> bool:
        most = CHARGED if _BATTERY in self._followed else LOW
        return fraction is not None and fraction < most

    def _follow(self, fault: Fault, why: str | None, now_s: float) -> Iterator[Event]:
        one = self._followed.setdefault(fault, _Followed(now_s, now_s))
        if why is not None:
            one.ill_s, one.why = now_s, why
            if not one.is_told and now_s - one.began_s >= BEGAN_S:
                one.is_told = True
                yield _event(fault, why, began=True)
        elif now_s - one.ill_s >= MENDED_S:
            del self._followed[fault]
            if one.is_told:
                yield _event(fault, one.why, began=False)


def _event(fault: Fault, why: str, *, began: bool) -> Event:
    part, which = fault
    if part == "room":
        return ClusterEvent(type="cluster.lost" if began else "cluster.back", room=int(which or 0))
    if part == "tunnel":
        return TunnelEvent(type="tunnel.lost" if began else "tunnel.back", why=why)
    return FaultEvent(
        type="fault.began" if began else "fault.mended", part=part, which=which, why=why
    )


def _code(problem: Sentence) -> str:
    """Return the code of a sentence, or of the one that it only prefixes with a name."""
    inner = problem.values.get("problem")
    return problem.code if inner is None or isinstance(inner, str | int | float) else inner.code
