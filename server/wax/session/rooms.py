"""The seats of those who watch in LiveKit rooms."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Final

from wax.cluster.room_directory import person
from wax.errors import FullError, NoPlaceError, NotAdmittedError
from wax.protocol import messages
from wax.sentence import Sentence
from wax.session.room_seats import Seats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.access.admission import Visitor
    from wax.session.page_messages import PageMessages
    from wax.session.parts import Parts

WATCHING_IS_FULL: Final = Sentence("door.watching_full")
_TOO_MANY: Final = Sentence("door.watching_full_for_address")
_FULL_AFTER_S: Final = 5
_LEAST_PER_ADDRESS: Final = 4
_CHECKED_AT_ONCE: Final = 200
"""A millisecond's work: checking a crowd must not delay driving."""
_SENT_AWAY_S: Final = 60.0


class Rooms:
    """Gives people seats in the rooms, and takes the seats back."""

    def __init__(self, parts: Parts, page_messages: PageMessages) -> None:
        self._clock = parts.clock
        self._cluster = parts.cluster
        self._access = parts.access
        self._viewers = parts.viewers
        self._turns = parts.turns
        self._page_messages = page_messages
        self._share = parts.settings.server.max_share_per_address
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
            hello=self._page_messages.hello(0, visitor, grant),
        )

    def renew(self, visitor: Visitor) -> None:
        """Note what a proxy says now of everybody who watches in this browser."""
        self._seats.renew(visitor)

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

    @property
    def is_checking(self) -> bool:
        """Whether such a check is still under way."""
        return bool(self._unchecked)

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

    # --- what falls due ----------------------------------------------------------------------

    @property
    def has_seats(self) -> bool:
        """Whether anybody watches in a LiveKit room."""
        return len(self._seats) > 0

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
