"""Everybody who is here, and what the control loop asks and tells about them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import structlog

from wax.protocol import messages

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.config.settings import RoleSyncSettings
    from wax.control.turns import TurnEvent, Turns
    from wax.session.viewer import Viewer

_LOG = structlog.get_logger(__name__)


class Viewers:
    """In the order in which they came; iterating tolerates that somebody leaves meanwhile."""

    def __init__(self, *, sync: RoleSyncSettings, turns: Turns, has_camera: bool) -> None:
        self._sync = sync
        self._turns = turns
        self._has_camera = has_camera
        self._viewers: dict[int, Viewer] = {}
        self._next_number = 1
        self._is_changed = False

    def __iter__(self) -> Iterator[Viewer]:
        return iter(list(self._viewers.values()))

    def __len__(self) -> int:
        return len(self._viewers)

    def take_number(self) -> int:
        """Return a number that no viewer has had."""
        number = self._next_number
        self._next_number += 1
        return number

    def add(self, viewer: Viewer) -> None:
        self._viewers[viewer.number] = viewer

    def remove(self, viewer: Viewer) -> None:
        del self._viewers[viewer.number]
        self.changed()

    def of_client(self, client: str | None) -> Viewer | None:
        """Return who has this identity; None where nobody has."""
        return next((one for one in self._viewers.values() if one.client == client), None)

    def changed(self) -> None:
        """Note that there is something to tell; many changes at once become one message."""
        self._is_changed = True

    def take_change(self) -> bool:
        """Tell whether there was a change since this was last asked."""
        is_changed, self._is_changed = self._is_changed, False
        return is_changed

    # --- what the control loop asks and tells ------------------------------------------------

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        """Follow the turns: the policy changes with the role, and everybody is told."""
        for event in events:
            _LOG.info("turn", what=type(event).__name__, number=getattr(event, "number", None))
        for viewer in self:
            drives = viewer.number == self._turns.operator
            with viewer.boundary:
                viewer.follow(self._sync.operator if drives else self._sync.observer, drives=drives)
        self.changed()

    def drive_status(self, number: int, moving: bool, reason: str | None) -> None:
        """Remember what becomes of an operator's commands; the next round tells them."""
        viewer = self._viewers.get(number)
        if viewer is not None:
            viewer.drive_status = messages.DriveStatus(moving=moving, reason=reason)

    def link_delay_s(self, number: int) -> float | None:
        """Return the measured one-way delay of a viewer's link."""
        if (viewer := self._viewers.get(number)) is not None:
            with viewer.boundary:
                return viewer.link.one_way_s
        return None

    def sees(self, number: int) -> bool:
        """Tell whether a viewer means to see: the picture is on, and there is one."""
        viewer = self._viewers.get(number)
        return viewer is not None and viewer.wants_picture and self._has_camera
