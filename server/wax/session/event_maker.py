"""Makes the events for the host's programs from what `record_keeper` sees."""

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
    """Each event goes to `send`; `seen` returns the polled state. No method raises."""

    def __init__(
        self, *, clock: Clock, seen: Callable[[], StateSeen], send: Callable[[events.Event], None]
    ) -> None:
        self._clock = clock
        self._seen = seen
        self._send = send
        self._changes = Changes()
        self._driving: events.TurnBegan | None = None
        self._software = ""
        self._contained = FirstErrorLogged("events are missing")

    def publish(self, event: events.Event) -> None:
        """Send an event, stamped with the current time."""
        with self._contained:
            now = datetime.fromtimestamp(self._clock.wall_ms() / 1000, UTC)
            stamped = {"timestamp": now.isoformat(timespec="milliseconds")}
            self._send(event.model_copy(update=stamped))

    def ready(self, software: str) -> None:
        """Publish that this version of the server is ready."""
        self._software = software
        self.publish(events.ServerEvent(type="server.ready", software=software))

    def poll(self) -> None:
        """Publish what has changed since the last poll."""
        with self._contained:
            for event in self._changes.compare(self._seen(), self._clock.now_s()):
                self.publish(event)

    def close(self) -> None:
        """Publish the end of the running turn and of the server."""
        self._end_turn("server_ending")
        if self._software:
            self.publish(events.ServerEvent(type="server.ending", software=self._software))

    def turn_began(self, turn: int, viewer: int, name: str) -> None:
        self._driving = events.TurnBegan(turn=turn, viewer=viewer, name=name)
        self.publish(self._driving)

    def turn_ended(self, why: Why) -> None:
        self._end_turn(cast("events.WhyEnded", why.name.lower()))

    def _end_turn(self, why: events.WhyEnded) -> None:
        began, self._driving = self._driving, None
        if began is not None:
            turn, viewer, name = began.turn, began.viewer, began.name
            self.publish(events.TurnEndedEvent(turn=turn, viewer=viewer, name=name, why=why))
