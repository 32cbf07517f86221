"""Contains errors, such as one viewer's in every callback from code that serves all viewers."""

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


class FirstErrorLogged:
    """A reusable context manager that suppresses exceptions and logs the first one.

    `event` is the log's event, `about` its values.
    """

    def __init__(self, event: str, **about: object) -> None:
        self._event = event
        self._about = about
        self._is_logged = False

    def __enter__(self) -> None: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        if not isinstance(error, Exception):
            return False
        if not self._is_logged:
            self._is_logged = True
            _LOG.error(self._event, exc_info=error, **self._about)
        return True


class ErrorBoundary(FirstErrorLogged):
    """Contains one viewer's errors; `around` wraps a callback.

    Each exception is also counted, and closes this viewer's peer by `end`, which may itself raise.
    """

    def __init__(self, *, viewer: int, counters: Counters, end: Callable[[], None]) -> None:
        super().__init__("error in one viewer; closing the peer", viewer=viewer)
        self._counters = counters
        self._end = end

    def around(self, call: Callable[_P, object]) -> Callable[_P, None]:
        """Return `call` wrapped in this boundary, for use as a callback."""

        def guarded(*args: _P.args, **kwargs: _P.kwargs) -> None:
            with self:
                call(*args, **kwargs)

        return guarded

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        if not super().__exit__(kind, error, trace):
            return False
        self._counters.add("viewer faults")
        with suppress(Exception):  # a peer that cannot be closed must not affect the others
            self._end()
        return True
