"""The one-way delay of the operator's link: measured when a turn begins, used until it ends.

A link whose delay grows during a turn gets no further allowance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


class OperatorDelay:
    """Asks `measure` for a viewer's one-way delay, in seconds, until it is known."""

    def __init__(self, measure: Callable[[int], float | None]) -> None:
        self._measure = measure
        self._one_way_s: float | None = None

    def begin(self) -> None:
        """Forget the measurement: a new operator, or a new connection."""
        self._one_way_s = None

    def renew(self, operator: int) -> None:
        """Measure again for a renewed turn; keep the old value if there is no new one."""
        self._one_way_s = self._measure(operator) or self._one_way_s

    def one_way_s(self, operator: int | None) -> float | None:
        """Return the delay to use, None while it is unknown."""
        if operator is not None and self._one_way_s is None:
            self._one_way_s = self._measure(operator)
        return self._one_way_s
