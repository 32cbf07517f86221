"""Everybody who is here: admits viewers, notices who has gone, and tells all what all may see."""

from __future__ import annotations

import asyncio
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final
from weakref import WeakValueDictionary

import structlog

from wax.errors import ForbiddenError, FullError
from wax.protocol import messages
from wax.rtc.peer import Peer
from wax.rtc.signalling import clean_offer
from wax.session.stop_authority import StopAuthority
from wax.session.viewer import Viewer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.clock import Clock
    from wax.config.settings import Settings
    from wax.control.gate import Command
    from wax.control.loop import ControlLoop
    from wax.control.turns import TurnEvent, Turns
    from wax.session.announcements import Announcements
    from wax.streams.interface import Service
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_ROUND_S: Final = 0.05
_LOOK_S: Final = 0.2
"""Robot and sources do not call when they fail; they are looked at this often."""
_MAX_CONNECTING: Final = 32
"""So many offers may be under way that have not opened their channels yet."""
_LOST_S: Final = 1.0
"""Five heartbeats missed: the link is lost, the robot stands, the turn is kept for the grace."""
_OTHERS_LOST_S: Final = 3.5
"""Who only watches is heard once a second, and whoever joins has just been doing that."""
_DEAD_S: Final = 10.0
"""Nothing for this long: the peer is closed; a page that is still there makes a new one."""
_ROOM_EVERY_S: Final = 5.0
_FLEETING: Final[dict[str, Any]] = {
    "viewers": {"__all__": {"wait_s"}},
    "robot": {"battery_v": True, "battery_fraction": True},
}
"""What changes all the time and is not worth a message each second."""


class Room:
    """The viewers, their peers and their queue; all methods belong to the event loop."""

    def __init__(
        self,
        *,
        settings: Settings,
        clock: Clock,
        counters: Counters,
        service: Service,
        turns: Turns,
        board: Announcements,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._counters = counters
        self._service = service
        self._turns = turns
        self._announcements = board
        self._control: ControlLoop | None = None
        self._viewers: dict[int, Viewer] = {}
        self._gone_since_s: dict[int, float] = {}
        self._next_number = 1
        self._answering: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()
        self._entry = asyncio.Lock()
        self._told = ""
        self._told_s = 0.0
        self._looked_s = 0.0
        self._is_changed = False

    def steer(self, control: ControlLoop) -> None:
        """Connect the control loop, which itself reports to this room."""
        self._control = control
        self._stops = StopAuthority(
            settings=self._settings.stop, turns=self._turns, control=control
        )

    @property
    def control(self) -> ControlLoop:
        assert self._control is not None
        return self._control

    @property
    def viewers(self) -> list[Viewer]:
        """Everybody, in the order of their coming."""
        return list(self._viewers.values())

    # --- admission -------------------------------------------------------------------------

    async def answer(self, client: str, offer: str, *, is_host: bool) -> str:
        """Answer a page's offer; the same `client` gets back the same place, turn and name.

        `is_host` says that the page is open on the server's own machine.

        Of two offers at once the later wins. Raises `FullError` or `SignallingError`.
        """
        # Before anything else: a bad offer shall neither take a place nor end a good peer.
        offer = clean_offer(offer)
        async with self._answering.setdefault(client, asyncio.Lock()):
            async with self._entry:
                # One in a pass of the event loop, which serves its timers once a pass: to answer
                # many in one would make the control loop as late as that takes.
                await asyncio.sleep(0)
            return await self._answer(client, offer, is_host=is_host)

    async def _answer(self, client: str, offer: str, *, is_host: bool) -> str:
        viewer = self._known(client)
        if viewer is not None and (old := viewer.peer) is not None:
            self._part(viewer)
            await old.close()
            viewer = self._known(client)
        if viewer is None:
            viewer = self._admit(client)
        viewer.is_host = is_host
        lanes = viewer.lanes()
        peer = Peer(
            ice_servers=self._settings.ice.servers,
            codecs=self._service.codecs,
            video=lanes.picture,
            audio=lanes.sound,
            way=lanes.way,
            events=viewer,
            clock=self._clock,
            round_trip_s=lambda: viewer.link.newest_s,
        )
        viewer.peer = peer
        self._gone_since_s.pop(viewer.number, None)
        return await peer.answer(offer)

    def _known(self, client: str | None) -> Viewer | None:
        return next((v for v in self._viewers.values() if v.client == client), None)

    def _admit(self, client: str) -> Viewer:
        if sum(not viewer.was_ready for viewer in self._viewers.values()) >= _MAX_CONNECTING:
            raise FullError("Too many are connecting at this moment; try again in a few seconds.")
        if len(self._viewers) >= self._settings.server.max_viewers:
            raise FullError(
                f"All {self._settings.server.max_viewers} places are taken; try again later."
            )
        viewer = Viewer(
            number=self._next_number,
            client=client,
            clock=self._clock,
            counters=self._counters,
            service=self._service,
            events=self,
            sync=self._settings.sync.observer,
        )
        self._next_number += 1
        self._viewers[viewer.number] = viewer
        return viewer

    # --- what viewers tell (ViewerEvents) --------------------------------------------------

    def viewer_connected(self, viewer: Viewer) -> None:
        _LOG.info("viewer connected", viewer=viewer.number)
        viewer.send(
            self._announcements.hello(viewer.number, is_host=viewer.is_host, lost_after_s=_LOST_S)
        )
        if self._turns.is_lost(viewer.number):
            self.control.returned(viewer.number)
        else:
            self.control.connect(viewer.number)
        self._told = ""
        self.changed()

    def viewer_closed(self, viewer: Viewer, peer: Peer) -> None:
        if peer is not viewer.peer:
            return
        _LOG.info("viewer's peer closed", viewer=viewer.number)
        self._part(viewer)
        if not viewer.was_ready:
            self._forget(viewer)

    def viewer_renamed(self) -> None:
        self.changed()

    def viewer_asks(self, viewer: Viewer, request: messages.Join | messages.Leave) -> None:
        if isinstance(request, messages.Join):
            self.control.join(viewer.number)
        else:
            self.control.leave(viewer.number)
        self.changed()

    def viewer_stops(self, viewer: Viewer) -> None:
        with self._refusing(viewer):
            self._stops.press(viewer, is_host=viewer.is_host)

    def viewer_releases(self, viewer: Viewer, release: messages.Release) -> None:
        with self._refusing(viewer):
            sent_s = release.sent_server_ms / 1000
            self._stops.release(viewer, release.stop, sent_s, is_host=viewer.is_host)

    def viewer_drives(self, viewer: Viewer, command: Command) -> None:
        self.control.offer(viewer.number, command)

    # --- stop and release by HTTP ----------------------------------------------------------

    def stop_by(self, client: str | None, *, is_host: bool) -> int:
        """Latch the stop, ahead of everything; returns its number. Raises `ForbiddenError`."""
        number = self._stops.press(self._known(client), is_host=is_host)
        self.changed()
        return number

    def release_by(self, client: str | None, stop: int, *, is_host: bool) -> None:
        """Release the stop with this number; raises `ForbiddenError`."""
        self._stops.release(self._known(client), stop, None, is_host=is_host)
        self.changed()

    @contextmanager
    def _refusing(self, viewer: Viewer) -> Iterator[None]:
        """Tell a viewer why what he asks for is refused."""
        try:
            yield
        except ForbiddenError as error:
            self._counters.add("requests refused")
            viewer.send(messages.Notice(text=str(error)))
        self.changed()

    # --- what the control loop asks and tells ------------------------------------------------

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        """Follow the turns: the policy changes with the role, and everybody is told."""
        for event in events:
            _LOG.info("turn", what=type(event).__name__, number=getattr(event, "number", None))
        for viewer in self.viewers:
            drives = viewer.number == self._turns.operator
            roles = self._settings.sync
            with viewer.boundary:
                viewer.follow(roles.operator if drives else roles.observer, drives=drives)
        self.changed()

    def drive_status(self, number: int, moving: bool, reason: str | None) -> None:
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
        """Tell whether a viewer means to see: he has not switched off a picture that there is."""
        viewer = self._viewers.get(number)
        return viewer is not None and viewer.wants_picture and self._announcements.has_camera

    def _part(self, viewer: Viewer) -> None:
        """Part a viewer from his peer: the robot stops if he drove, his place is kept a while."""
        viewer.peer = None
        with viewer.boundary:
            viewer.release()
        self.control.lost(viewer.number)
        self._gone_since_s[viewer.number] = self._clock.now_s()
        self.changed()

    # --- the room's own rounds -------------------------------------------------------------

    def changed(self) -> None:
        """Tell everybody with the next round; many changes at once become one message."""
        self._is_changed = True

    async def run(self) -> None:
        """Sweep for lost links and tell everybody what has changed, until cancelled."""
        while True:
            await asyncio.sleep(_ROUND_S)
            self.round(self._clock.now_s())

    def round(self, now_s: float) -> None:
        """Do one round; however much changes, the rounds keep their pace."""
        self._sweep(now_s)
        for viewer in self.viewers:
            with viewer.boundary:
                viewer.tell_drive_status(now_s)
        if self._is_changed or now_s - self._looked_s >= _LOOK_S:
            self._is_changed = False
            self._looked_s = now_s
            self._tell(now_s)

    def snapshot(self, now_s: float) -> messages.RoomState:
        """Return the room as everybody may see it."""
        return self._announcements.room(
            self._viewers.values(), self.control.robot_state, self.control.latched, now_s
        )

    async def close(self) -> None:
        """Close every peer."""
        await asyncio.gather(*(viewer.close() for viewer in self.viewers))

    def _sweep(self, now_s: float) -> None:
        for viewer in self.viewers:
            if viewer.peer is None:
                since_s = self._gone_since_s.setdefault(viewer.number, now_s)
                if now_s - since_s >= self._settings.turns.grace_s:
                    self._forget(viewer)
                continue
            silence_s = viewer.link.silence_s(now_s)
            with viewer.boundary:
                if silence_s > _DEAD_S or not viewer.peer.is_alive:
                    viewer.peer.abandon()
                    continue
            if viewer.is_ready and silence_s > self._patience_s(viewer):
                self.control.lost(viewer.number)
            elif viewer.is_ready and self._turns.is_lost(viewer.number):
                self.control.returned(viewer.number)

    def _patience_s(self, viewer: Viewer) -> float:
        return _LOST_S if viewer.number == self._turns.operator else _OTHERS_LOST_S

    def _forget(self, viewer: Viewer) -> None:
        _LOG.info("viewer gone", viewer=viewer.number)
        del self._viewers[viewer.number]
        self._gone_since_s.pop(viewer.number, None)
        self.control.gone(viewer.number)
        self.changed()

    def _tell(self, now_s: float) -> None:
        snapshot = self.snapshot(now_s)
        lasting = snapshot.model_dump_json(exclude=_FLEETING)
        if lasting == self._told and now_s - self._told_s < _ROOM_EVERY_S:
            return
        self._told, self._told_s = lasting, now_s
        text = snapshot.model_dump_json()
        for viewer in self.viewers:
            if viewer.is_ready:
                viewer.send_text(text)  # inside the viewer's own boundary
