"""One viewer's fault is one viewer's: around every call into a viewer from what serves all."""

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
    """Use as a context manager, as often as needed, or through `around`.

    What is raised inside goes no further: it is counted, the first one is logged, and `end` is
    called, which ends this viewer's peer and may itself raise.
    """

    def __init__(self, *, viewer: int, counters: Counters, end: Callable[[], None]) -> None:
        self._viewer = viewer
        self._counters = counters
        self._end = end
        self._is_logged = False

    def around(self, call: Callable[_P, object]) -> Callable[_P, None]:
        """Return `call` inside this boundary, for those who call back later."""

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
            _LOG.error("a viewer's fault, closing the peer", viewer=self._viewer, exc_info=error)
        with suppress(Exception):  # who cannot be ended must not harm the others either
            self._end()
        return True
