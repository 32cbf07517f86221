"""How much of the event loop's time each stranger may use. Pure.

Each has a committed rate and, beyond it, what is left of a common pool, of which one address gets
at most half (two rates, after RFC 2698). So a flooder spends the pool and then waits; anybody
within the committed rate is served at once, whatever the others do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final
from weakref import WeakValueDictionary

_ADDRESS_SHARE: Final = 0.5
_LONGEST_WAIT_S: Final = 1.0
"""However much a step has cost: a garbage collection is charged to the step it interrupts."""


@dataclass(frozen=True, slots=True)
class Rates:
    """Seconds of processor time; the rates are per second."""

    committed: float
    """For each payer: many viewers at one address are as many payers."""
    committed_burst_s: float
    pool: float
    pool_burst_s: float


class Budget:
    """The pool that one kind of strangers shares; `payer` opens an account for each."""

    def __init__(self, rates: Rates) -> None:
        self._rates = rates
        self._pool = _Level(rates.pool, rates.pool_burst_s)
        self._addresses: WeakValueDictionary[str, _Level] = WeakValueDictionary()

    def payer(self, address: str) -> Payer:
        """Return a new account for somebody at this address."""
        rates = self._rates
        shared = self._addresses.get(address)
        if shared is None:
            share = _ADDRESS_SHARE
            shared = _Level(share * rates.pool, share * rates.pool_burst_s)
            self._addresses[address] = shared
        return Payer(_Level(rates.committed, rates.committed_burst_s), (self._pool, shared))


class Payer:
    """One stranger's account; all times come from one clock."""

    def __init__(self, own: _Level, shared: tuple[_Level, ...]) -> None:
        self._own = own
        self._shared = shared

    def spend(self, cost_s: float, now_s: float) -> None:
        """Charge `cost_s` seconds of processor time, which may leave a debt."""
        rest_s = cost_s - self._own.take_up_to(cost_s, now_s)
        if rest_s <= 0:
            return
        if all(level.left_s(now_s) > 0 for level in self._shared):
            for level in self._shared:
                level.owe(rest_s)
        else:
            self._own.owe(rest_s)

    def wait_s(self, now_s: float) -> float:
        """Return how long to wait before the next step, 1 s at most; 0 to go on at once."""
        if self._own.left_s(now_s) > 0 or all(one.left_s(now_s) > 0 for one in self._shared):
            return 0.0
        return self._own.recovers_in_s(now_s)


class _Level:
    """A token bucket of seconds, whose debt is at most what refills in 1 s."""

    __slots__ = ("__weakref__", "_burst_s", "_filled_s", "_left_s", "_rate")

    def __init__(self, rate: float, burst_s: float) -> None:
        self._rate = rate
        self._burst_s = burst_s
        self._left_s = burst_s
        self._filled_s = float("-inf")

    def left_s(self, now_s: float) -> float:
        """Return what is left; a clock that runs backwards adds nothing."""
        if now_s > self._filled_s:
            self._left_s = min(self._left_s + (now_s - self._filled_s) * self._rate, self._burst_s)
            self._filled_s = now_s
        return self._left_s

    def take_up_to(self, cost_s: float, now_s: float) -> float:
        """Take `cost_s`, or all that is left; return how much was taken."""
        taken_s = min(cost_s, max(self.left_s(now_s), 0.0))
        self._left_s -= taken_s
        return taken_s

    def owe(self, cost_s: float) -> None:
        self._left_s = max(self._left_s - cost_s, -self._rate * _LONGEST_WAIT_S)

    def recovers_in_s(self, now_s: float) -> float:
        return max(-self.left_s(now_s), 0.0) / self._rate
