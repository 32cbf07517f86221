"""An event maker for tests that are not about events, and a list of its events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wax.session.changes import StateSeen
from wax.session.event_maker import EventMaker

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.protocol.events import Event

QUIET = StateSeen(is_open=True, waiting=0)


class Heard:
    """Receives events, and returns them without the fields that all have."""

    def __init__(self, clock: Clock, seen: Callable[[], StateSeen] = lambda: QUIET) -> None:
        self.events: list[Event] = []
        self.event_maker = EventMaker(clock=clock, seen=seen, send=self.events.append)

    def take(self) -> list[dict[str, Any]]:
        """Return the events since the last call."""
        told = [event.model_dump(exclude={"version", "timestamp"}) for event in self.events]
        self.events.clear()
        return told
