"""The one-way delay of the operator's link: measured when a turn begins, and used throughout it.

A link that becomes slower within a turn earns no further allowance.
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
        """Forget what was measured: another operator, or another connection of theirs."""
        self._one_way_s = None

    def renew(self, operator: int) -> None:
        """Measure anew for a turn that renews; what was known stays if nothing is known now."""
        self._one_way_s = self._measure(operator) or self._one_way_s

    def one_way_s(self, operator: int | None) -> float | None:
        """Return the delay to go by, None while it is unknown."""
        if operator is not None and self._one_way_s is None:
            self._one_way_s = self._measure(operator)
        return self._one_way_s
