"""The queue for people who watch in LiveKit rooms.

Somebody who waits is a viewer without a peer; their page connects ten seconds before their turn
(`web/src/rooms/visit.ts`), which does not begin before it has (`wax.control.turns`).
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, Literal

from wax.errors import ForbiddenError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.access.admission import Visitor
    from wax.protocol import messages
    from wax.session.entry import Entry
    from wax.session.page_messages import PageMessages
    from wax.session.parts import Parts
    from wax.session.presence import Presence
    from wax.session.viewer import Viewer

Wants = Literal["join", "leave", "here", "stay"]

_NOT_QUEUED: Final = Sentence("queue.not_in")
_NO_ROOMS: Final = Sentence("queue.no_rooms")
_STAYS_S: Final = 20.0
"""A waiting page renews its place four times as often."""


class RoomQueue:
    """Carries out what pages in the LiveKit rooms ask of the queue."""

    def __init__(
        self, parts: Parts, page_messages: PageMessages, presence: Presence, entry: Entry
    ) -> None:
        self._clock = parts.clock
        self._cluster = parts.cluster
        self._access = parts.access
        self._viewers = parts.viewers
        self._turns = parts.turns
        self._control = parts.control
        self._page_messages = page_messages
        self._presence = presence
        self._entry = entry

    def request(
        self, visitor: Visitor, tab: str, wants: Wants, name: str | None = None
    ) -> messages.ViewerInfo:
        """Carry out the request of a page in a LiveKit room; return its line of the room's state.

        The place lapses unless the page asks again within `_STAYS_S`; `name` is shown to others.
        Raises `NotAdmittedError`, `FullError`, and `ForbiddenError` with the reason why the page
        may not queue, for example because there are no LiveKit rooms.
        """
        if not self._cluster.is_used:
            raise ForbiddenError(_NO_ROOMS)
        now_s = self._clock.now_s()
        viewer = self._viewers.of_tab(visitor.identity, tab)
        if viewer is None:
            if wants != "join":
                raise ForbiddenError(_NOT_QUEUED)
            viewer = self._entry.admit_to_queue(visitor, tab)
        if viewer.peer is None:
            viewer.update_access(visitor, self._access.admit(visitor))
            self._presence.connect(viewer, is_here=False)
        viewer.in_room_until_s = now_s + _STAYS_S
        with self._forgetting_unplaced(viewer):
            self._carry_out(viewer, wants)
            if name is not None:
                viewer.request_name(name)
        self._viewers.changed()
        return self._page_messages.line(viewer, now_s)

    def _carry_out(self, viewer: Viewer, wants: Wants) -> None:
        match wants:
            case "join":
                self._presence.join(viewer)
            case "leave":
                self._control.leave(viewer.number)
            case "here":
                self._control.answer_call(viewer.number)
            case "stay":
                pass

    @contextmanager
    def _forgetting_unplaced(self, viewer: Viewer) -> Iterator[None]:
        """Afterwards forget the viewer if they have neither a peer nor a place."""
        try:
            yield
        finally:
            if viewer.peer is None and self._turns.place(viewer.number) is None:
                self._presence.forget(viewer)
