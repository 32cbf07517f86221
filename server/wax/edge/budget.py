"""How much of the event loop's time each stranger may use. Pure.

Each has a committed rate and, beyond it, what is left of a common pool, of which one address gets
at most half (two rates, after RFC 2698). So a flooder spends the pool and then waits; anybody
within the committed rate is served at once, whatever the others do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final
from weakref import WeakValueDictionary

from wax.rate_limits import TokenBucket

_ADDRESS_SHARE: Final = 0.5


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
        self._pool = TokenBucket(rates.pool, rates.pool_burst_s)
        self._addresses: WeakValueDictionary[str, TokenBucket] = WeakValueDictionary()

    def payer(self, address: str) -> Payer:
        """Return a new account for somebody at this address."""
        rates = self._rates
        shared = self._addresses.get(address)
        if shared is None:
            share = _ADDRESS_SHARE
            shared = TokenBucket(share * rates.pool, share * rates.pool_burst_s)
            self._addresses[address] = shared
        own = TokenBucket(rates.committed, rates.committed_burst_s)
        return Payer(own, (self._pool, shared))


class Payer:
    """One stranger's account; all times come from one clock."""

    def __init__(self, own: TokenBucket, shared: tuple[TokenBucket, ...]) -> None:
        self._own = own
        self._shared = shared

    def spend(self, cost_s: float, now_s: float) -> None:
        """Charge `cost_s` seconds of processor time, which may leave a debt of a second's rate.

        It is no larger: a garbage collection is charged to the step it interrupts.
        """
        own_s = min(cost_s, max(self._own.level(now_s), 0.0))
        self._own.owe(own_s)
        is_shared = all(one.level(now_s) > 0 for one in self._shared)
        for bucket in self._shared if is_shared else (self._own,):
            bucket.owe(cost_s - own_s)

    def credit_s(self, now_s: float) -> float:
        """Return what is left of the account: the more, the less this stranger has used lately."""
        return self._own.level(now_s)

    def wait_s(self, now_s: float) -> float:
        """Return how long to wait before the next step, 1 s at most; 0 to go on at once."""
        if self._own.level(now_s) > 0 or all(one.level(now_s) > 0 for one in self._shared):
            return 0.0
        return self._own.recovers_in_s(now_s)
