"""Finds the turns whose operators do not want their recording to be used. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.protocol.tape_events import Disowned, Turned

if TYPE_CHECKING:
    from wax.protocol.tape_events import TapeEvent

Span = tuple[float, float]
"""A begin and an end, in seconds since 1970."""


class DisownedTurns:
    """Give it all events in order of time, with their times in seconds since 1970."""

    def __init__(self) -> None:
        self._open: tuple[int, float] | None = None
        self._turns: dict[int, Span] = {}
        self.spans: list[Span] = []
        """When the turns were driven that are not to be used."""

    def add(self, at_s: float, event: TapeEvent) -> None:
        """Add an event."""
        match event:
            case Turned(operator=None):
                self._end(at_s)
            case Turned(number=number):
                if self._open is None or self._open[0] != number:
                    self._end(at_s)
                    self._open = number, at_s
            case Disowned(turn=turn) if turn in self._turns:
                self.spans.append(self._turns[turn])

    def _end(self, at_s: float) -> None:
        if self._open is not None:
            number, began_s = self._open
            self._turns[number] = began_s, at_s
        self._open = None


def is_within(at_s: float, spans: list[Span]) -> bool:
    """Whether a time lies in one of the spans."""
    return any(begin_s <= at_s <= end_s for begin_s, end_s in spans)
