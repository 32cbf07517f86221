"""Which turns are reported one by one; of a flood of empty ones only the number is. Pure.

Joining an idle robot's queue and leaving it is a turn. A few people could have a hundred a second,
and fill a disk and every receiver of events with them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.rate_limits import TokenBucket

if TYPE_CHECKING:
    from wax.control.turns import TurnStarted

_TURNS_HZ: Final = 0.2
_TURNS_BURST: Final = 20
LASTS_S: Final = 2.0


class TurnThrift:
    """Reports twenty turns as they begin, and one more every five seconds.

    Any other is reported once it has lasted for two seconds, or its operator has driven; `left_out`
    counts those that ended before.
    """

    def __init__(self) -> None:
        self._allowed = TokenBucket(rate_hz=_TURNS_HZ, burst=_TURNS_BURST)
        self._held: tuple[TurnStarted, float] | None = None
        self.left_out = 0

    def began(self, turn: TurnStarted, now_s: float) -> bool:
        """Whether to report this turn now."""
        self._held = None if self._allowed.take(now_s) else (turn, now_s)
        return self._held is None

    def due(self, now_s: float, *, is_driven: bool = False) -> TurnStarted | None:
        """Return the turn to report belatedly, None if there is none."""
        held = self._held
        if held is None or (now_s - held[1] < LASTS_S and not is_driven):
            return None
        self._held = None
        return held[0]

    def ended(self) -> None:
        """Note that the turn is over; if it was not reported, it never will be."""
        self.left_out += self._held is not None
        self._held = None
