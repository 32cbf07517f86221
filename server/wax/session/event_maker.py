"""Makes the events that programs of the host's are told, of what the records' keeper sees."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, cast

from wax.error_boundary import FirstErrorLogged
from wax.protocol import events
from wax.session.changes import Changes

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.control.turns import Why
    from wax.session.changes import StateSeen


class EventMaker:
    """Each event goes to `tell`; `seen` returns what is polled. No method raises."""

    def __init__(
        self, *, clock: Clock, seen: Callable[[], StateSeen], tell: Callable[[events.Event], None]
    ) -> None:
        self._clock = clock
        self._seen = seen
        self._tell_others = tell
        self._changes = Changes()
        self._driving: events.TurnBegan | None = None
        self._software = ""
        self._contained = FirstErrorLogged("events are missing")

    def tell(self, event: events.Event) -> None:
        """Tell an event, as of now."""
        with self._contained:
            now = datetime.fromtimestamp(self._clock.wall_ms() / 1000, UTC)
            stamped = {"timestamp": now.isoformat(timespec="milliseconds")}
            self._tell_others(event.model_copy(update=stamped))

    def ready(self, software: str) -> None:
        """Tell that the server of this version serves."""
        self._software = software
        self.tell(events.ServerEvent(type="server.ready", software=software))

    def look(self) -> None:
        """Tell what has changed since the last look."""
        with self._contained:
            for event in self._changes.look(self._seen(), self._clock.now_s()):
                self.tell(event)

    def close(self) -> None:
        """Tell that the server ends, with the turn that runs."""
        self._turn_over("server_ending")
        if self._software:
            self.tell(events.ServerEvent(type="server.ending", software=self._software))

    def turn_began(self, turn: int, viewer: int, name: str) -> None:
        self._driving = events.TurnBegan(turn=turn, viewer=viewer, name=name)
        self.tell(self._driving)

    def turn_ended(self, why: Why) -> None:
        self._turn_over(cast("events.WhyEnded", why.name.lower()))

    def _turn_over(self, why: events.WhyEnded) -> None:
        began, self._driving = self._driving, None
        if began is not None:
            turn, viewer, name = began.turn, began.viewer, began.name
            self.tell(events.TurnEndedEvent(turn=turn, viewer=viewer, name=name, why=why))
