"""Calls the next in the queue before their turn, to check that they are there.

A viewer who has just done something is not called. A viewer who does not answer in time is passed
over until the next turn has begun, and keeps their place once; after two missed calls they lose it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Call:
    """`viewer` has until `until_s` to answer."""

    viewer: int
    until_s: float
    is_answered: bool = False


class ReadyCheck:
    """The open call, and who has missed one; with a `ready_s` of 0 nobody is called."""

    def __init__(self, ready_s: float) -> None:
        self._ready_s = ready_s
        self._seen_s: dict[int, float] = {}  # when they last did something on purpose
        self._missed: set[int] = set()
        self._passed_over: set[int] = set()
        self.call: Call | None = None

    def record_activity(self, viewer: int, now_s: float) -> None:
        """Record that a viewer has done something on purpose, which answers their call."""
        self._seen_s[viewer] = now_s
        self._missed.discard(viewer)
        self._passed_over.discard(viewer)
        if self.call is not None and self.call.viewer == viewer:
            self.call = replace(self.call, is_answered=True)

    def forget(self, viewer: int) -> None:
        """Forget a viewer who has left."""
        self._seen_s.pop(viewer, None)
        self._missed.discard(viewer)
        self._passed_over.discard(viewer)
        self.cancel(viewer)

    def cancel(self, viewer: int) -> None:
        """Cancel a viewer's call, without counting it as missed."""
        if self.call is not None and self.call.viewer == viewer:
            self.call = None

    def is_passed_over(self, viewer: int) -> bool:
        return viewer in self._passed_over

    def is_ready(self, viewer: int, now_s: float) -> bool:
        """Whether this viewer's turn may begin without another call."""
        if not self._ready_s:
            return True
        if self.call is not None and self.call.viewer == viewer and self.call.is_answered:
            return True
        return now_s - self._seen_s.get(viewer, -self._ready_s) < self._ready_s

    def is_due(self, turn_ends_s: float | None, now_s: float) -> bool:
        """Whether it is time to call the next viewer."""
        return turn_ends_s is None or now_s >= turn_ends_s - self._ready_s

    def start_call(self, viewer: int, now_s: float) -> Call | None:
        """Call a viewer, which ends any other's call; None if they are already called."""
        if self.call is not None and self.call.viewer == viewer:
            return None
        self.call = Call(viewer, now_s + self._ready_s)
        return self.call

    def confirm(self, viewer: int) -> None:
        """Record an answered call for a viewer who was active just now, without asking them."""
        self.call = Call(viewer, math.inf, is_answered=True)

    @property
    def expires_s(self) -> float:
        """When the open call counts as missed; infinite without one."""
        call = self.call
        return math.inf if call is None or call.is_answered else call.until_s

    def expire(self) -> tuple[int, bool]:
        """Close the missed call; return the viewer, and whether it was their second."""
        assert self.call is not None
        viewer, self.call = self.call.viewer, None
        is_second = viewer in self._missed
        self._missed.add(viewer)
        self._passed_over.add(viewer)
        return viewer, is_second

    def begin_turn(self) -> None:
        """Record that a turn begins or renews: those passed over may be called again."""
        self.call = None
        self._passed_over.clear()
