"""How a visitor becomes a viewer: their offer is checked, given a place and answered."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final
from weakref import WeakValueDictionary

import structlog

from wax.errors import FullError, NoPlaceError, SignallingError
from wax.rtc.peer import Peer
from wax.rtc.signalling import clean_offer, lacking
from wax.sentence import Sentence
from wax.session.capacity import EMBEDS_FULL, Asking, Capacity
from wax.session.viewer import Viewer

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.access.admission import Grant, Visitor
    from wax.session.parts import Parts
    from wax.session.presence import Presence
    from wax.session.viewer import ViewerEvents
    from wax.voice.packet import VoicePacket

_LOG = structlog.get_logger(__name__)

_MOST_EXPECTED: Final = 100
"""People who wait in the queue here while they watch in a LiveKit room."""
_MACHINE_FULL: Final = Sentence("door.machine_full")


class Entry:
    """Makes viewers and their peers; `events` gets what happens to them."""

    def __init__(self, parts: Parts, presence: Presence, events: ViewerEvents) -> None:
        settings = parts.settings
        self._sync = settings.sync.observer
        self._clock = parts.clock
        self._counters = parts.counters
        self._service = parts.pipelines.service
        self._network = parts.network
        self._access = parts.access
        self._viewers = parts.viewers
        self._headroom = parts.headroom
        self._voices = parts.voices
        self._presence = presence
        self._events = events
        self._capacity = Capacity(
            most=settings.server.max_viewers,
            most_silent_per_address=settings.server.max_silent_per_address,
            share_per_address=settings.server.max_share_per_address,
        )
        self._lacking: set[str] = set()
        self._answering: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    def connected(self, number: int) -> None:
        """Note that a viewer's channels have opened."""
        self._capacity.connected(number)

    async def answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        """Answer a page's offer; the same tab of the same browser keeps its place, turn and name.

        An empty one is answered with an offer, which the page's `accept` follows. Of two
        concurrent offers the later one wins. Raises `NotAdmittedError`, `FullError`,
        `TooOftenError` or `SignallingError`.
        """
        viewer = self._viewers.of_tab(visitor.identity, tab)
        embeds = sum(one.visitor.is_embed and one is not viewer for one in self._viewers)
        self._capacity.check(self._asking(visitor, viewer), self._clock.now_s(), embeds)
        await asyncio.sleep(0)  # this pass of the event loop has parsed the request
        # Before anything else: a bad offer must neither take a place nor end a good peer.
        offer = offer and self._checked(visitor, offer)
        key = f"{visitor.identity} {tab}"
        async with self._answering.setdefault(key, asyncio.Lock()):
            await asyncio.sleep(0)  # each step in a pass of its own
            return await self._answer(visitor, tab, offer)

    async def accept(self, visitor: Visitor, tab: str, answer: str) -> None:
        """Accept the page's answer to our offer; raises `NotAdmittedError` or `SignallingError`."""
        self._access.admit(visitor)
        viewer = self._viewers.of_tab(visitor.identity, tab)
        if viewer is None or viewer.peer is None:
            raise SignallingError(Sentence("request.unanswerable"))
        await asyncio.sleep(0)  # each step in a pass of its own
        await viewer.peer.accept(self._checked(visitor, answer))

    def _checked(self, visitor: Visitor, sdp: str) -> str:
        """Return what matters of a page's description; raises `SignallingError`."""
        clean = clean_offer(sdp, visitor.address, self._service.codecs.names)
        if (lacks := lacking(clean, self._service.codecs)) is not None:
            self._report_lacking(lacks)
            raise SignallingError(lacks)
        return clean

    def _report_lacking(self, sentence: Sentence) -> None:
        """Warn once per codec that a browser lacks it."""
        if sentence.code in self._lacking:
            return
        self._lacking.add(sentence.code)
        _LOG.warning(
            "a browser was refused because it lacks our codec",
            said=str(sentence),
        )

    async def _answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        grant = self._access.admit(visitor)
        viewer = self._viewers.of_tab(visitor.identity, tab)
        number = self._admit(visitor, viewer)
        if viewer is not None and (old := viewer.peer) is not None:
            self._presence.drop_peer(viewer)
            await old.close()
            viewer = self._viewers.of_tab(visitor.identity, tab)
            number = self._viewers.take_number() if viewer is None else number
        if viewer is None:
            viewer = self._enter(visitor, grant, tab, number)
        viewer.update_access(visitor, grant)
        lanes = viewer.make_lanes()
        peer = Peer(
            network=self._network,
            meter=self._network.meter(visitor.address, lambda: self._is_trusted(viewer)),
            codecs=self._service.codecs,
            lanes=lanes,
            events=viewer,
            clock=self._clock,
            round_trip_s=lambda: viewer.link.newest_s,
            on_voice=self._voice_of(viewer),
        )
        viewer.peer, viewer.in_room_until_s = peer, float("-inf")
        return await (peer.answer(offer) if offer else peer.offer())

    def _is_trusted(self, viewer: Viewer) -> bool:
        return self._events.viewer_role(viewer) not in ("observer", "embed")

    def _voice_of(self, viewer: Viewer) -> Callable[[VoicePacket | None], None] | None:
        voices = self._voices
        return None if voices is None else lambda packet: voices.receive(viewer, packet)

    def admit_to_queue(self, visitor: Visitor, tab: str) -> Viewer:
        """Make a viewer of somebody who watches in a LiveKit room; raises what `answer` does."""
        grant = self._access.admit(visitor)
        others = [one.visitor for one in self._viewers]
        self._access.admission.check_tabs(visitor, others)
        now_s = self._clock.now_s()
        if sum(one.is_in_room(now_s) for one in self._viewers) >= _MOST_EXPECTED:
            raise FullError(Sentence("queue.full"), retry_after_s=5)
        viewer = self._enter(visitor, grant, tab, self._viewers.take_number())
        viewer.was_ready = True  # so that their place is kept
        return viewer

    def _admit(self, visitor: Visitor, viewer: Viewer | None) -> int:
        """Return the viewer's number if there is room for them; raises what `answer` does."""
        now_s = self._clock.now_s()
        others = [one for one in self._viewers if one is not viewer]
        if viewer is None:
            self._access.admission.check_tabs(visitor, [one.visitor for one in others])
        asking = self._asking(visitor, viewer)
        embeds = [one for one in others if one.visitor.is_embed]
        here = [one for one in others if not one.is_in_room(now_s)]
        served = sum(one.is_ready for one in others)  # others cost next to nothing
        lacks = None if asking.is_host or asking.has_been_here else self._shortage(served)
        if lacks is not None and (asking.is_embed or not embeds):
            raise NoPlaceError(lacks, retry_after_s=3 if lacks == _MACHINE_FULL else 5)
        number = self._viewers.take_number() if viewer is None else viewer.number
        present = [self._asking(one.visitor, None) for one in here]
        displaced = self._capacity.admit(number, asking, present, now_s)
        if displaced.silent is not None:
            self._abandon(displaced.silent)
        if lacks is not None or displaced.an_embed:
            self._presence.send_away(embeds[0], EMBEDS_FULL)
        return number

    def _shortage(self, served: int) -> Sentence | None:
        """Return what is too scarce for one more beside `served` viewers, None if nothing is."""
        if not self._service.has_room:
            return Sentence("door.upload_full")
        if not self._headroom.has_time(served):
            return _MACHINE_FULL
        return None

    def _abandon(self, number: int) -> None:
        """End the peer of a viewer who has not connected yet: a newcomer gets their place."""
        for viewer in self._viewers:
            if viewer.number == number and viewer.peer is not None:
                with viewer.boundary:
                    viewer.peer.abandon()

    def _enter(self, visitor: Visitor, grant: Grant, tab: str, number: int) -> Viewer:
        viewer = Viewer(
            number=number,
            visitor=visitor,
            grant=grant,
            tab=tab,
            clock=self._clock,
            counters=self._counters,
            service=self._service,
            events=self._events,
            sync=self._sync,
        )
        self._viewers.add(viewer)
        return viewer

    def _asking(self, visitor: Visitor, viewer: Viewer | None) -> Asking:
        keeps_place = viewer is not None and viewer.was_ready
        if viewer is not None and viewer.is_in_room(self._clock.now_s()):
            keeps_place = self._presence.is_due(viewer)
        drives = viewer is not None and self._is_trusted(viewer)
        return Asking(visitor.address, visitor.is_host, keeps_place, drives, visitor.is_embed)
