"""Contains one viewer's errors: around every call into a viewer from code that serves all."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, ParamSpec

import structlog

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_P = ParamSpec("_P")


class ErrorBoundary:
    """A reusable context manager; `around` wraps a callback in it.

    Exceptions inside are suppressed and counted, the first one is logged, and `end` is called,
    which closes this viewer's peer and may itself raise.
    """

    def __init__(self, *, viewer: int, counters: Counters, end: Callable[[], None]) -> None:
        self._viewer = viewer
        self._counters = counters
        self._end = end
        self._is_logged = False

    def around(self, call: Callable[_P, object]) -> Callable[_P, None]:
        """Return `call` wrapped in this boundary, for use as a callback."""

        def guarded(*args: _P.args, **kwargs: _P.kwargs) -> None:
            with self:
                call(*args, **kwargs)

        return guarded

    def __enter__(self) -> None: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        if not isinstance(error, Exception):
            return False
        self._counters.add("viewer faults")
        if not self._is_logged:
            self._is_logged = True
            _LOG.error("error in one viewer; closing the peer", viewer=self._viewer, exc_info=error)
        with suppress(Exception):  # a peer that cannot be closed must not harm the others
            self._end()
        return True
