"""People who watch in LiveKit rooms: their seats there, their places in the queue here.

Somebody who waits is a viewer without a peer; their page connects ten seconds before their turn
(`web/src/rooms/visit.ts`), which does not begin before it has (`wax.control.turns`).
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Final, Literal

from wax.cluster.room_directory import person
from wax.errors import ForbiddenError, FullError, NoPlaceError, NotAdmittedError
from wax.protocol import messages
from wax.sentence import Sentence
from wax.session.room_seats import Seats

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from wax.access.access import Access
    from wax.access.admission import Visitor
    from wax.clock import Clock
    from wax.cluster.cluster import Cluster
    from wax.config.server import ServerSettings
    from wax.control.loop import ControlLoop
    from wax.control.turns import Turns
    from wax.session.entry import Entry
    from wax.session.page_messages import PageMessages
    from wax.session.viewer import Viewer
    from wax.session.viewers import Viewers

Wants = Literal["join", "leave", "here", "stay"]

WATCHING_IS_FULL: Final = Sentence("door.watching_full")
_TOO_MANY: Final = Sentence("door.watching_full_for_address")
_NOT_QUEUED: Final = Sentence("queue.not_in")
_NO_ROOMS: Final = Sentence("queue.no_rooms")
_FULL_AFTER_S: Final = 5
_LEAST_PER_ADDRESS: Final = 4
_STAYS_S: Final = 20.0
"""A waiting page renews its place four times as often."""
_DUE_S: Final = 15.0
_CHECKED_AT_ONCE: Final = 200
"""A millisecond's work: checking a crowd must not delay driving."""
_SENT_AWAY_S: Final = 60.0


class Rooms:
    """Gives people seats in the rooms, and takes the seats back.

    `wait` tells the turns that a viewer waits in a room, `join` puts a viewer into the queue or
    raises `ForbiddenError`, `forget` drops a viewer.
    """

    def __init__(
        self,
        *,
        settings: ServerSettings,
        clock: Clock,
        cluster: Cluster,
        access: Access,
        viewers: Viewers,
        turns: Turns,
        control: ControlLoop,
        entry: Entry,
        page_messages: PageMessages,
        wait: Callable[[Viewer], None],
        join: Callable[[Viewer], None],
        forget: Callable[[Viewer], None],
        lost_after_s: float,
    ) -> None:
        self._clock = clock
        self._cluster = cluster
        self._access = access
        self._viewers = viewers
        self._turns = turns
        self._control = control
        self._entry = entry
        self._page_messages = page_messages
        self._wait = wait
        self._join = join
        self._forget = forget
        self._lost_after_s = lost_after_s
        self._share = settings.max_share_per_address
        self._seats = Seats()
        self._unchecked: list[str] = []
        self._sent_away: dict[str, tuple[Sentence, Sequence[messages.Opening], float]] = {}

    # --- seats -------------------------------------------------------------------------------

    def has_seat(self, visitor: Visitor) -> bool:
        """Whether this browser watches in a room."""
        return self._seats.has(visitor.identity)

    def of_tab(self, tab: str) -> Visitor | None:
        """Return who watches in a room in the tab with this secret; None if nobody does."""
        seated = self._seats.of_tab(tab)
        return None if seated is None else seated.visitor

    def since_s(self, address: str) -> dict[str, float]:
        """Return since when each browser at an address has watched in a room."""
        return self._seats.since_s(address)

    def seat(self, visitor: Visitor, tab: str) -> messages.SentToRoom:
        """Give a visitor a seat, or renew theirs, and return where it is.

        Raises `NotAdmittedError` if they may not watch, and `FullError` if no seat is free.
        """
        now_s = self._clock.now_s()
        name = person(visitor.identity, tab)
        self._check_sent_away(name, now_s)
        seated = self._seats.get(name)
        try:
            grant = self._access.admit(visitor)
        except NotAdmittedError as error:
            if seated is not None:
                self._end(name, error.sentence, error.openings)
            raise
        if seated is None:
            self._check_room(visitor)
        seats = self._cluster.seats(name, () if seated is None else seated.rooms)
        links = self._cluster.links
        if seats:
            self._seats.give(visitor, tab, [one.room for one in seats], now_s)
        elif not links:
            raise FullError(WATCHING_IS_FULL, retry_after_s=_FULL_AFTER_S)
        grant = replace(grant, hear=grant.hear and self._cluster.has_sound)
        return messages.SentToRoom(
            wall_ms=self._clock.wall_ms(),
            rooms=[messages.Seat(url=one.url, token=one.token) for one in seats],
            links=links,
            hello=self._page_messages.hello(0, visitor, grant, lost_after_s=self._lost_after_s),
        )

    def leave(self, visitor: Visitor, tab: str) -> None:
        """Take back the seat of a page that is closed, if it has one."""
        self._seats.remove(person(visitor.identity, tab))

    def seat_instead(self, visitor: Visitor, tab: str, here: NoPlaceError) -> messages.SentToRoom:
        """Give a seat to a visitor who got no place here; raises what `seat` does.

        Without a cluster, raise `here`, the reason why they got none.
        """
        if not self._cluster.is_used:
            raise here
        return self.seat(visitor, tab)

    def send_away(
        self, identity: str, sentence: Sentence, openings: Sequence[messages.Opening] = ()
    ) -> None:
        """Take all seats of a browser, and refuse it new ones with the sentence for a minute."""
        for seated in self._seats.of_identity(identity):
            self._end(seated.person, sentence, openings)

    def check_all(self) -> None:
        """Schedule a check of whether everybody may still watch."""
        self._unchecked = self._seats.people()

    def _check_sent_away(self, name: str, now_s: float) -> None:
        self._sent_away = {one: why for one, why in self._sent_away.items() if now_s < why[2]}
        if name in self._sent_away:
            sentence, openings, _ = self._sent_away[name]
            raise NotAdmittedError(sentence, openings)

    def _check_room(self, visitor: Visitor) -> None:
        """Raise `FullError` if there is no seat for one more page of this person."""
        own = self._seats.of_identity(visitor.identity)
        here = [one.visitor for one in self._viewers]
        self._access.admission.check_tabs(visitor, [*here, *(one.visitor for one in own)])
        capacity = self._cluster.capacity
        if capacity and len(self._seats) >= capacity:
            raise FullError(WATCHING_IS_FULL, retry_after_s=_FULL_AFTER_S)
        most = max(_LEAST_PER_ADDRESS, int(capacity * self._share))
        if not visitor.is_host and self._seats.at(visitor.address) >= most:
            raise FullError(_TOO_MANY, retry_after_s=_FULL_AFTER_S)

    def _end(self, name: str, sentence: Sentence, openings: Sequence[messages.Opening]) -> None:
        self._seats.remove(name)
        self._sent_away[name] = (sentence, openings, self._clock.now_s() + _SENT_AWAY_S)
        self._cluster.remove(name, for_good=True)

    # --- the queue ---------------------------------------------------------------------------

    def queue(
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
            self._wait(viewer)
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
                self._join(viewer)
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
                self._forget(viewer)

    def is_due(self, viewer: Viewer) -> bool:
        """Whether somebody who waits in a room may connect here because their turn is near."""
        place = self._turns.place(viewer.number)
        wait_s = self._turns.wait_s(viewer.number, self._clock.now_s())
        return place in (0, 1) or (wait_s is not None and wait_s <= _DUE_S)

    # --- what falls due ----------------------------------------------------------------------

    def round(self, now_s: float) -> None:
        """Take back expired seats, and check whether the next people may stay; cheap."""
        for over in self._seats.expire(now_s):
            self._cluster.remove(over.person)
        for name in islice(self._unchecked, _CHECKED_AT_ONCE):
            seated = self._seats.get(name)
            if seated is not None:
                try:
                    self._access.admit(self._access.refreshed(seated.visitor))
                except NotAdmittedError as error:
                    self._end(name, error.sentence, error.openings)
        del self._unchecked[:_CHECKED_AT_ONCE]

    def message(self, room: messages.RoomState, now_s: float) -> str | None:
        """Return the message for everybody in the LiveKit rooms; None if nobody is there."""
        if not len(self._seats):
            return None
        return self._page_messages.for_rooms(room, self._watching(), now_s).model_dump_json()

    def _watching(self) -> int:
        """Count everybody who watches or waits, here or in a LiveKit room, except the operator.

        Somebody who connects here from a room for their turn is in both, and counts once.
        """
        there = self._cluster.watching
        for viewer in self._viewers:
            is_there = self._seats.get(person(viewer.visitor.identity, viewer.tab)) is not None
            drives = viewer.number == self._turns.operator
            if is_there and drives:
                there -= 1
            elif not is_there and not drives and viewer.peer is not None:
                there += 1
        return max(there, 0)
