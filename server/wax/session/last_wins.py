"""Runs requests at a bounded rate; a newer one replaces one that waits. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.token_bucket import TokenBucket

_T = TypeVar("_T")


class LastWins(Generic[_T]):
    """Calls `do` with requests as often as `allowed`; the last one is never lost."""

    def __init__(self, do: Callable[[_T], None], allowed: TokenBucket) -> None:
        self._do = do
        self._allowed = allowed
        self._waiting: list[_T] = []

    def submit(self, request: _T, now_s: float) -> None:
        """Run the request now, or later in place of one that still waits."""
        self._waiting = [request]
        self.run_waiting(now_s)

    @property
    def is_waiting(self) -> bool:
        return bool(self._waiting)

    def run_waiting(self, now_s: float) -> None:
        """Run the waiting request if the rate allows it by now."""
        if self._waiting and self._allowed.take(now_s):
            self._do(self._waiting.pop())
