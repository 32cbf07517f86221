"""What strangers may use of one pass of the event loop, and who of them waits.

asyncio runs its timers, and with them the control loop, once a pass. So the work of all strangers
together gets two milliseconds of each pass, and what is left waits for the next: no command of the
operator's and no Stop is behind more than that.
"""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.edge.budget import Payer

_PASS_S: Final = 0.002


class Turnstile:
    """One for the event loop, from which everything here is called."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._used_s = 0.0
        self.charged_s = 0.0
        """What was charged to anybody since the start."""

    @property
    def is_open(self) -> bool:
        """Whether a stranger's work may still begin in this pass."""
        return self._used_s < _PASS_S

    def wait_s(self, payer: Payer) -> float:
        """Return how long this payer must wait, 0 if it need not, whatever this pass has left."""
        return payer.wait_s(self._clock.now_s())

    def charge(self, payer: Payer, began_s: float) -> None:
        """Charge what this thread has done since `began_s`, which was its `time.thread_time()`."""
        cost_s = time.thread_time() - began_s
        if not self._used_s:
            asyncio.get_running_loop().call_soon(self._next_pass)
        self._used_s += cost_s
        self.charged_s += cost_s
        payer.spend(cost_s, self._clock.now_s())

    def _next_pass(self) -> None:
        self._used_s = 0.0


class Meter:
    """One peer at the turnstile.

    While it is trusted, as the operator and the host are, it is charged to an account of its own
    that no honest page ever uses up, and does not wait for others' work.
    """

    def __init__(
        self,
        turnstile: Turnstile,
        guest: Payer,
        trusted: Payer | None = None,
        is_trusted: Callable[[], bool] = lambda: False,
    ) -> None:
        self._turnstile = turnstile
        self._guest = guest
        self._trusted = trusted
        self._is_trusted = is_trusted

    @property
    def _payer(self) -> Payer:
        if self._trusted is not None and self._is_trusted():
            return self._trusted
        return self._guest

    @property
    def is_open(self) -> bool:
        """Whether something of this peer's may be handled now."""
        payer = self._payer
        has_room = payer is self._trusted or self._turnstile.is_open
        return has_room and self._turnstile.wait_s(payer) <= 0

    def charge(self, began_s: float) -> None:
        """Charge this peer (`Turnstile.charge`)."""
        self._turnstile.charge(self._payer, began_s)

    async def enter(self) -> None:
        """Wait until something of this peer's may be handled; at once where it may now."""
        while True:
            if self.is_open:
                return
            await asyncio.sleep(self._turnstile.wait_s(self._payer))
