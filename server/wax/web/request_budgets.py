"""Who pays for HTTP's share of the event loop: guests by address, known people by identity."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from wax.bounded_dict import BoundedDict
from wax.edge.budget import Budget, Rates

if TYPE_CHECKING:
    from wax.access.access import Shown
    from wax.edge.budget import Payer
    from wax.edge.turnstile import Turnstile

HOST: Final = "host"
"""The name that `RequestBudgets.who` returns for the host."""
Who = Callable[["Shown", str, str, str], tuple[str, bool] | None]
"""Returns who sends these cookies, from this address, and whether this route is urgent for them,
given their tab's secret; None for a stranger."""

_GUESTS: Final = Rates(committed=0.005, committed_burst_s=0.05, pool=0.2, pool_burst_s=0.6)
"""All guests together get a fifth of a core, and one address half of that. At half a millisecond a
request, each address gets a page of ten, then ten requests a second, whatever the others do."""
_KNOWN: Final = Rates(committed=0.01, committed_burst_s=0.1, pool=0.1, pool_burst_s=0.3)
"""Everybody in the room has a reserve that no neighbour at their address can use up."""
_HOST: Final = Rates(committed=0.5, committed_burst_s=1.0, pool=0.0, pool_burst_s=0.0)
_MOST: Final = 1024
"""Budgets that are kept: those used most recently."""


class RequestBudgets:
    """`has_people_at` says whether somebody at an address is in the room."""

    def __init__(
        self,
        turnstile: Turnstile,
        who: Who = lambda *_: None,
        has_people_at: Callable[[str], bool] = lambda _: False,
    ) -> None:
        self._turnstile = turnstile
        self.who = who
        self._has_people_at = has_people_at
        self._budgets = {"guest": Budget(_GUESTS), "known": Budget(_KNOWN), "host": Budget(_HOST)}
        self._payers = BoundedDict[tuple[str, str], "Payer"](_MOST)

    def of_guest(self, address: str) -> Payer:
        """Return the budget of an address."""
        return self._payer("guest", address, address)

    def of_known(self, name: str, address: str) -> Payer | None:
        """Return a known person's budget; None if it is used up: they pay as a guest."""
        payer = self._payer(HOST if name == HOST else "known", name, address)
        return payer if self._turnstile.wait_s(payer) <= 0 else None

    def of_newcomer(self, address: str) -> tuple[Payer, bool]:
        """Return who pays for a new connection, and whether somebody in the room likely made it."""
        known = self.of_known(address, address) if self._has_people_at(address) else None
        return (self.of_guest(address), False) if known is None else (known, True)

    def _payer(self, kind: str, name: str, address: str) -> Payer:
        payer = self._payers.get((kind, name)) or self._budgets[kind].payer(address)
        self._payers[kind, name] = payer
        return payer
