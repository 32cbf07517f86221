"""Which way is tried next, and when. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.door.ssh import Way

STEADY_S: Final = 10.0
"""A tunnel that has stood this long was a good one."""
SOON_S: Final = 0.3
FIRST_S: Final = 0.5
LONGEST_S: Final = 1.0
"""Short: with ssh's own limit, whoever waits for the door waits five seconds at most."""
HOPELESS_S: Final = 10.0
_OWN_TAKES: Final = 12
"""So often in a row a port may be held by our own last connection, which the door soon closes."""
HOPELESS: Final = frozenset({"host_key", "key", "key_file", "no_ssh", "no_user"})
"""What nobody mends but the host."""
_OTHER: Final = 4
"""Once a way has worked, the other is tried each so many failures."""


class Attempts:
    """TCP 22 first, then 443 in turn with it, until one of them has worked."""

    def __init__(self) -> None:
        self._works: Way | None = None
        self._failures = 0
        self._taken = 0
        self._way: Way = "ssh"

    @property
    def way(self) -> Way:
        """The one to try now."""
        return self._way

    def opened(self) -> None:
        """Note that the tunnel stands."""
        self._works = self._way

    def ended(self, code: str, stood_s: float) -> float:
        """Note why it has ended after standing this long; return the seconds until the next."""
        self._failures = 0 if stood_s >= STEADY_S else self._failures + 1
        self._way = self._next()
        self._taken = self._taken + 1 if code == "taken" else 0
        # Whoever had the port before asks more often, and so has it again.
        if code in HOPELESS or self._taken > _OWN_TAKES:
            return HOPELESS_S
        if not self._failures:
            return SOON_S
        return FIRST_S if self._failures == 1 else LONGEST_S

    def _next(self) -> Way:
        if self._works is not None and self._failures % _OTHER:
            return self._works
        if not self._failures:
            return self._way
        return "https" if self._way == "ssh" else "ssh"
