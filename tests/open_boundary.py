"""A boundary that lets every fault through, so that a test sees it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from wax.error_boundary import ErrorBoundary
from wax.telemetry import Counters

if TYPE_CHECKING:
    from types import TracebackType


class OpenFence(ErrorBoundary):
    """Raises what a boundary would catch."""

    def __init__(self) -> None:
        super().__init__(viewer=0, counters=Counters(), end=lambda: None)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> Literal[False]:
        return False
