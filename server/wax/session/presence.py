"""Who is here, lost or gone: how viewers connect, queue, fall silent and are sent away."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

import structlog

from wax.control.fairness import Person
from wax.errors import ForbiddenError, NotAdmittedError
from wax.fanout.batches import in_batches
from wax.protocol import messages
from wax.rate_limits import TokenBuckets
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.access.admission import Visitor
    from wax.session.parts import Parts
    from wax.session.rooms import Rooms
    from wax.session.viewer import Viewer

_LOG = structlog.get_logger(__name__)

LOST_S: Final = 1.0
"""Five missed heartbeats: the link is lost, the robot stops, the turn is kept for a grace time."""
_OTHERS_LOST_S: Final = 3.5
"""The same for viewers who do not drive; observers send a heartbeat only once a second."""
_DEAD_S: Final = 10.0
"""A peer that is silent for this long is closed; a page that is still open makes a new one."""
_HALF_OPEN_S: Final = 9.0
"""The same for a peer whose channels have not opened yet."""
_GOODBYE_S: Final = 0.1
"""SCTP sends a message on later passes of the event loop; closing a peer drops what is left."""
GOODBYE: Final = Sentence("door.goodbye")
_DUE_S: Final = 15.0
_JOINS_HZ: Final = 0.5
_JOINS_BURST: Final = 10
"""Per browser: joining an idle robot's queue and leaving it is a turn, which all are told."""
_MOST_JOINING: Final = 1000
_JOINS_TOO_OFTEN: Final = Sentence("queue.too_often")
_SIGNED_OUT: Final = Sentence("host.signed_out")


class Presence:
    """Tells the control loop who comes, queues, is lost and goes."""

    def __init__(self, parts: Parts, rooms: Rooms) -> None:
        self._clock = parts.clock
        self._access = parts.access
        self._viewers = parts.viewers
        self._turns = parts.turns
        self._control = parts.control
        self._grace_s = parts.settings.turns.grace_s
        self._rooms = rooms
        self._one_place = parts.settings.access.proxy.one_place
        self._joins = TokenBuckets(rate_hz=_JOINS_HZ, burst=_JOINS_BURST, most=_MOST_JOINING)
        self._gone_since_s: dict[int, float] = {}

    def watches_from(self, address: str) -> dict[str, float]:
        """Return since when each browser at an address has watched, here or in a LiveKit room."""
        since_s = self._rooms.since_s(address)
        for one in self._viewers:
            if one.was_ready and one.visitor.address == address and not one.visitor.is_embed:
                who = one.visitor.identity
                since_s[who] = min(one.since_s, since_s.get(who, one.since_s))
        return since_s

    def is_due(self, viewer: Viewer) -> bool:
        """Whether somebody who waits in a room may connect here because their turn is near."""
        place = self._turns.place(viewer.number)
        wait_s = self._turns.wait_s(viewer.number, self._clock.now_s())
        return place in (0, 1) or (wait_s is not None and wait_s <= _DUE_S)

    # --- coming and going --------------------------------------------------------------------

    def connect(self, viewer: Viewer, *, is_here: bool = True) -> None:
        """Register a viewer who has connected, or who waits in a room (`is_here` false)."""
        self._control.connect(viewer.number, self._person(viewer), is_here=is_here)

    def join(self, viewer: Viewer) -> None:
        """Put a viewer into the queue; raises `ForbiddenError` with the reason if it cannot."""
        joins = self._turns.place(viewer.number) is None
        if joins and not self._joins.take(viewer.visitor.identity, self._clock.now_s()):
            raise ForbiddenError(_JOINS_TOO_OFTEN)
        refusal = self._control.join(viewer.number)
        if refusal is not None:
            raise ForbiddenError(refusal)

    def drop_peer(self, viewer: Viewer) -> None:
        """Drop a viewer's peer: the robot stops if they drove; they keep their place for now."""
        viewer.peer = None
        with viewer.boundary:
            viewer.release()
        now_s = self._clock.now_s()
        self._control.lost(viewer.number)
        if viewer.is_in_room(now_s):  # their page announced it before it disconnected
            self.connect(viewer, is_here=False)
        else:
            self._gone_since_s[viewer.number] = now_s
        self._viewers.changed()

    def send_away(
        self, viewer: Viewer, sentence: Sentence, openings: Sequence[messages.Opening] = ()
    ) -> None:
        """Tell a viewer why they may not stay, and forget them."""
        _LOG.info("viewer sent away", viewer=viewer.number, why=str(sentence))
        self._rooms.send_away(viewer.visitor.identity, sentence, openings)
        viewer.send(messages.Ended(text=sentence, openings=list(openings)))
        peer, viewer.peer = viewer.peer, None
        with viewer.boundary:
            viewer.release()
        self.forget(viewer)
        if peer is not None:
            # Later, because the message must be sent before the channel closes.
            asyncio.get_running_loop().call_later(_GOODBYE_S, peer.abandon)

    def forget(self, viewer: Viewer) -> None:
        log = _LOG.info if viewer.was_ready else _LOG.debug
        log("viewer gone", viewer=viewer.number)
        self._viewers.remove(viewer)
        self._gone_since_s.pop(viewer.number, None)
        self._control.gone(viewer.number)

    async def close(self) -> None:
        """Say goodbye to every page and close its peer."""
        for viewer in self._viewers:
            viewer.send(messages.Goodbye(text=GOODBYE))
        if len(self._viewers) > 0:
            await asyncio.sleep(_GOODBYE_S)
        await asyncio.gather(*(viewer.close() for viewer in self._viewers))

    def renew(self, viewer: Viewer, visitor: Visitor) -> None:
        """Note what a proxy says now of a viewer; the next check acts on it."""
        was_host = viewer.visitor.is_host
        viewer.visitor = replace(viewer.visitor, vouched=visitor.vouched)
        if viewer.visitor.is_host != was_host and viewer.peer is not None:
            with viewer.boundary:
                viewer.peer.abandon()  # the page connects again, and learns what it may do

    # --- whether everybody may stay ----------------------------------------------------------

    def check_all(self) -> None:
        """Soon send away everybody here who may no longer stay, and update the others' rights."""
        in_batches([partial(self._check, viewer) for viewer in self._viewers])

    def check_rooms(self) -> None:
        """Soon do the same for everybody who watches in a LiveKit room."""
        self._rooms.check_all()

    def _check(self, viewer: Viewer) -> None:
        if self._viewers.numbered(viewer.number) is None:
            return  # gone since this was scheduled
        visitor = self._access.refreshed(viewer.visitor)
        if viewer.visitor.sign_in and not visitor.is_host:
            viewer.visitor = visitor
            self.send_away(viewer, _SIGNED_OUT)
            return
        try:
            grant = self._access.admit(visitor)
        except NotAdmittedError as error:
            self.send_away(viewer, error.sentence, error.openings)
        else:
            viewer.update_access(visitor, grant)
            self._control.update_person(viewer.number, self._person(viewer))

    # --- silence -----------------------------------------------------------------------------

    def sweep(self, now_s: float) -> None:
        """Note who is lost and who is back, and forget who has been gone for the grace time."""
        for viewer in self._viewers:
            if viewer.is_in_room(now_s):
                continue
            if viewer.peer is None:
                if not self._turns.is_lost(viewer.number):  # their page has stopped renewing
                    self._control.lost(viewer.number)
                since_s = self._gone_since_s.setdefault(viewer.number, now_s)
                if now_s - since_s >= self._grace_s:
                    self.forget(viewer)
                continue
            silence_s = viewer.link.silence_s(now_s)
            with viewer.boundary:
                dead_s = _DEAD_S if viewer.is_ready else _HALF_OPEN_S
                if silence_s > dead_s or not viewer.peer.is_alive:
                    viewer.peer.abandon()
                    continue
            if viewer.is_ready and silence_s > self._lost_after_s(viewer):
                if not self._turns.is_lost(viewer.number):
                    _LOG.info("viewer silent", viewer=viewer.number)
                self._control.lost(viewer.number)
            elif viewer.is_ready and self._turns.is_lost(viewer.number):
                self._control.returned(viewer.number)

    def _lost_after_s(self, viewer: Viewer) -> float:
        return LOST_S if viewer.number == self._turns.operator else _OTHERS_LOST_S

    def _person(self, viewer: Viewer) -> Person:
        visitor = viewer.visitor
        key = visitor.identity if self._one_place else f"{visitor.identity} {visitor.device}"
        may_queue = viewer.grant.queue and not visitor.is_embed
        return Person(key, visitor.address, visitor.is_invited, may_queue)
