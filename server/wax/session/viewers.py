"""The registry of viewers, and what the control loop asks and tells about them."""

from __future__ import annotations

from secrets import compare_digest
from typing import TYPE_CHECKING, Final

import structlog

from wax.control.listener import Listener
from wax.control.turns import PlaceLost, TurnEnded, TurnStarted, Why
from wax.protocol import messages
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.access.host_decisions import HostDecisions
    from wax.config.sync import RoleSyncSettings
    from wax.control.turns import TurnEvent, Turns
    from wax.session.viewer import Viewer

_LOG = structlog.get_logger(__name__)

_TOLD: Final = {
    Why.IDLE: Sentence("turn.idle"),
    Why.ENDED: Sentence("turn.ended"),
    Why.NOT_ALLOWED: Sentence("queue.not_invited"),
}
"""What an operator reads when their turn ends unexpectedly."""


class Viewers(Listener):
    """The viewers in order of arrival; viewers may leave during an iteration."""

    def __init__(
        self, *, sync: RoleSyncSettings, turns: Turns, has_camera: bool, decisions: HostDecisions
    ) -> None:
        self._sync = sync
        self._turns = turns
        self._has_camera = has_camera
        self._decisions = decisions
        self._viewers: dict[int, Viewer] = {}
        self._next_number = 1
        self._is_changed = False

    def __iter__(self) -> Iterator[Viewer]:
        return iter(list(self._viewers.values()))

    def __len__(self) -> int:
        return len(self._viewers)

    def take_number(self) -> int:
        """Return a number that no viewer has had before."""
        number = self._next_number
        self._next_number += 1
        return number

    def add(self, viewer: Viewer) -> None:
        self._viewers[viewer.number] = viewer

    def remove(self, viewer: Viewer) -> None:
        del self._viewers[viewer.number]
        self.changed()

    def of_tab(self, identity: str, tab: str | None) -> Viewer | None:
        """Return the viewer that is this tab of this browser; None if there is none."""
        return next((one for one in self.of_identity(identity) if one.tab == tab), None)

    def of_secret(self, tab: str) -> Viewer | None:
        """Return the newest viewer with this tab secret, of any browser; None if there is none."""
        if not (tab and tab.isascii()):
            return None
        return next((one for one in reversed([*self]) if compare_digest(one.tab, tab)), None)

    def of_identity(self, identity: str) -> list[Viewer]:
        """Return all viewers of one browser."""
        return [one for one in self._viewers.values() if one.visitor.identity == identity]

    def numbered(self, number: int) -> Viewer | None:
        """Return the viewer with this number; None if they are gone."""
        return self._viewers.get(number)

    def changed(self) -> None:
        """Mark the room as changed; many changes at once become one message."""
        self._is_changed = True

    def take_change(self) -> bool:
        """Return whether anything has changed since the last call."""
        is_changed, self._is_changed = self._is_changed, False
        return is_changed

    # --- what the control loop tells (Listener) -----------------------------------------------

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        """Apply the policy of each new role, and inform everybody."""
        for event in events:
            why = event.why.value if isinstance(event, TurnEnded) else None
            number = getattr(event, "number", None)
            _LOG.info("turn", what=type(event).__name__, number=number, why=why)
            if isinstance(event, TurnEnded) and event.why in _TOLD:
                self._notify(event.operator, _TOLD[event.why])
            elif isinstance(event, PlaceLost) and event.why is not None:
                self._notify(event.viewer, event.why)
        roles = {one.operator for one in events if isinstance(one, TurnStarted | TurnEnded)}
        for viewer in filter(None, map(self.numbered, roles)):
            drives = viewer.number == self._turns.operator
            with viewer.boundary:
                viewer.set_role(
                    self._sync.operator if drives else self._sync.observer, drives=drives
                )
        self.changed()

    def _notify(self, number: int, sentence: Sentence) -> None:
        if (viewer := self._viewers.get(number)) is not None:
            viewer.send(messages.Notice(text=sentence))

    def drive_status(
        self, number: int, moving: bool, reason: Sentence | None, share: float
    ) -> None:
        """Store the status of an operator's commands; the next round sends it."""
        viewer = self._viewers.get(number)
        if viewer is not None:
            viewer.drive_status = messages.DriveStatus(moving=moving, reason=reason, share=share)

    # --- what it asks (Operators) --------------------------------------------------------------

    @property
    def on_hold(self) -> Sentence | None:
        """Why the host lets nobody drive; None if people may."""
        return self._decisions.on_hold

    def link_delay_s(self, number: int) -> float | None:
        """Return half the least round trip of a viewer's last 10 s, in s; None if unknown."""
        if (viewer := self._viewers.get(number)) is not None:
            with viewer.boundary:
                return viewer.link.one_way_s
        return None

    def sees(self, number: int) -> bool:
        """Whether a viewer wants the picture: it is on, and there is a camera."""
        viewer = self._viewers.get(number)
        return viewer is not None and viewer.wants_picture and self._has_camera

    def max_fraction(self, number: int) -> float:
        """Return how much of the robot's speed a viewer may use: the host's limit is for guests."""
        viewer = self._viewers.get(number)
        is_host = viewer is not None and viewer.visitor.is_host
        return 1.0 if is_host else self._decisions.switches.max_fraction
