"""Which way to the door is tried next, and when. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.door.ssh import Way

STABLE_S: Final = 10.0
"""A tunnel that lasted this long had worked."""
SOON_S: Final = 0.3
FIRST_S: Final = 0.5
LONGEST_S: Final = 1.0
"""Short: with ssh's own timeout, the tunnel is up at most 5 s after its door is."""
HOPELESS_S: Final = 10.0
_OWN_TAKES: Final = 12
"""Attempts in a row that may find the port held by our own last connection, which soon expires."""
HOPELESS: Final = frozenset({"host_key", "key", "key_file", "no_ssh", "no_user"})
"""The failures that only the host can fix."""
_OTHER: Final = 4
"""Once a way has worked, only one failure in this many tries the other."""


class Attempts:
    """TCP 22 first, then 443 in turn with it, until one of them has worked."""

    def __init__(self) -> None:
        self._works: Way | None = None
        self._failures = 0
        self._taken = 0
        self._way: Way = "ssh"

    @property
    def way(self) -> Way:
        """The way to try now."""
        return self._way

    def opened(self) -> None:
        """Note that the tunnel is open."""
        self._works = self._way

    def ended(self, code: str, lasted_s: float) -> float:
        """Note why the tunnel ended after `lasted_s`; return the seconds until the next attempt."""
        self._failures = 0 if lasted_s >= STABLE_S else self._failures + 1
        self._way = self._next()
        self._taken = self._taken + 1 if code == "taken" else 0
        # The robot that held the port retries sooner than a newcomer, and so gets it back.
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
