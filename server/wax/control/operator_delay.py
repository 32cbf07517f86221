"""Estimates the one-way delay of the operator's link: half the shortest round trip of their turn.

A link whose delay grows during a turn gets no further allowance, and the estimate falls once a busy
link is idle. While the delay is too long to drive, each new measurement replaces the last: a single
late answer costs nobody their turn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.control.command_freshness import time_to_live_s

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.control.rules import Rules


class OperatorDelay:
    """`measure` returns half of a viewer's shortest recent round trip, in seconds."""

    def __init__(self, measure: Callable[[int], float | None], rules: Rules) -> None:
        self._measure = measure
        self._rules = rules
        self._one_way_s: float | None = None

    def begin(self) -> None:
        """Forget the estimate, for a new operator or a new connection."""
        self._one_way_s = None

    def renew(self, operator: int) -> None:
        """Measure again for a renewed turn; keep the old value if there is no new one."""
        measured_s = self._measure(operator)
        if measured_s is not None:
            self._one_way_s = measured_s

    def one_way_s(self, operator: int | None) -> float | None:
        """Return the delay to use, None while it is unknown."""
        least_s = self._one_way_s
        if operator is not None:
            self.renew(operator)
        if least_s is not None and self._one_way_s is not None and self._is_drivable(least_s):
            self._one_way_s = min(least_s, self._one_way_s)
        return self._one_way_s

    def _is_drivable(self, one_way_s: float) -> bool:
        return time_to_live_s(one_way_s, self._rules) is not None
