"""A request that may be repeated at will, carried out at a bounded rate. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.session.token_bucket import TokenBucket

_T = TypeVar("_T")


class LastWins(Generic[_T]):
    """Calls `do` with what is asked for, as often as `allowed`; the last request is never lost."""

    def __init__(self, do: Callable[[_T], None], allowed: TokenBucket) -> None:
        self._do = do
        self._allowed = allowed
        self._waiting: list[_T] = []

    def ask(self, request: _T, now_s: float) -> None:
        """Carry the request out now, or later in place of one that still waits."""
        self._waiting = [request]
        self.settle(now_s)

    @property
    def is_waiting(self) -> bool:
        return bool(self._waiting)

    def settle(self, now_s: float) -> None:
        """Carry out what waits, if that is allowed by now."""
        if self._waiting and self._allowed.take(now_s):
            self._do(self._waiting.pop())
