"""Wait for the next tick of a fixed rate."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock


class FrameTimer:
    """Ticks every `period_s` on `clock`; `wait` sleeps for this long, or returns True to end.

    A tick that is more than `patience_s` late restarts the schedule, so that a machine that slept
    does not catch up on missed ticks.
    """

    def __init__(
        self,
        period_s: float,
        clock: Clock,
        wait: Callable[[float], bool],
        patience_s: float = 0.25,
    ) -> None:
        self._period_s = period_s
        self._clock = clock
        self._wait = wait
        self._patience_s = patience_s
        self._due_s = clock.now_s()

    def beat(self) -> float:
        """Block until the next tick is due and return when it was due."""
        self._due_s += self._period_s
        now_s = self._clock.now_s()
        if now_s > self._due_s + self._patience_s:
            self._due_s = now_s
        while now_s < self._due_s:
            if self._wait(self._due_s - now_s):
                break
            now_s = self._clock.now_s()
        return self._due_s
