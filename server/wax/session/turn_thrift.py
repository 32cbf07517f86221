"""Which turns are recorded and told one by one: of a flood of empty ones only their number. Pure.

Whoever joins an idle robot's queue and leaves it, has had a turn. Some of them could have a hundred
a second, and fill a disk and every receiver of events with them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.session.token_bucket import TokenBucket

if TYPE_CHECKING:
    from wax.control.turns import TurnStarted

_TURNS_HZ: Final = 0.2
_TURNS_BURST: Final = 20
LASTS_S: Final = 2.0


class TurnThrift:
    """Twenty turns are told as they begin, and one more each five seconds.

    Any other is told once it has lasted for two seconds, or its operator has driven; `left_out`
    counts those that ended before.
    """

    def __init__(self, now_s: float) -> None:
        self._allowed = TokenBucket(rate_hz=_TURNS_HZ, burst=_TURNS_BURST, now_s=now_s)
        self._held: tuple[TurnStarted, float] | None = None
        self.left_out = 0

    def began(self, turn: TurnStarted, now_s: float) -> bool:
        """Whether this turn is told now."""
        self._held = None if self._allowed.take(now_s) else (turn, now_s)
        return self._held is None

    def due(self, now_s: float, *, is_driven: bool = False) -> TurnStarted | None:
        """Return the turn that is to be told after all."""
        held = self._held
        if held is None or (now_s - held[1] < LASTS_S and not is_driven):
            return None
        self._held = None
        return held[0]

    def ended(self) -> None:
        """Note that the turn is over; one that was not told will not be."""
        self.left_out += self._held is not None
        self._held = None
