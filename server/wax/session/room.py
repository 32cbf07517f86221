"""The room: admits viewers, notices when they are lost, and sends everybody its state."""

from __future__ import annotations

import asyncio
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

import structlog

from wax.access.permissions import check
from wax.control.fairness import Person
from wax.errors import ForbiddenError, FullError, NotAdmittedError
from wax.fanout.batches import in_batches
from wax.house.commands import ReleaseAt
from wax.protocol import messages, room_change
from wax.rate_limits import TokenBuckets
from wax.sentence import Sentence
from wax.session import names
from wax.session.diagnosis import for_guests
from wax.session.entry import Entry
from wax.session.host_acts import SIGNED_OUT, HostActs
from wax.session.kept_state import KeptState
from wax.session.room_updates import RoomUpdates
from wax.session.rooms import Rooms
from wax.session.stop_budget import StopBudget

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from wax.access.access import Access
    from wax.access.admission import Visitor
    from wax.access.permissions import Role
    from wax.clock import Clock
    from wax.cluster.cluster import Cluster
    from wax.config.settings import Settings
    from wax.control.controls import Operation
    from wax.control.gate import Command
    from wax.control.loop import ControlLoop
    from wax.control.reasons import Refusal
    from wax.control.turns import Turns
    from wax.house.commands import HouseAct
    from wax.records.records import Records
    from wax.rtc.network import Network
    from wax.rtc.peer import Peer
    from wax.session.host_decisions import HostDecisions
    from wax.session.kept_state import KeptFile
    from wax.session.page_messages import PageMessages
    from wax.session.record_keeper import RecordKeeper
    from wax.session.tape_keeper import TapeKeeper
    from wax.session.viewer import Request, Viewer
    from wax.session.viewers import Viewers
    from wax.session.voices import Voices
    from wax.streams.interface import Service
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_ROUND_S: Final = 0.05
_POLL_S: Final = 0.2
"""The robot and the sources have no callback for failures; they are polled this often."""
_LOST_S: Final = 1.0
"""Five missed heartbeats: the link is lost, the robot stops, the turn is kept for a grace time."""
_OTHERS_LOST_S: Final = 3.5
"""The same for viewers who do not drive; observers send a heartbeat only once a second."""
_DEAD_S: Final = 10.0
"""A peer that is silent for this long is closed; a page that is still open makes a new one."""
_HALF_OPEN_S: Final = 9.0
"""The same for a peer whose channels have not opened yet."""
_GOODBYE_S: Final = 0.1
"""SCTP sends a message on later passes of the event loop; closing a peer drops what is left."""
_GOODBYE: Final = Sentence("door.goodbye")
_CHECK_S: Final = 1.0
"""How often to check whether everybody may still stay: hours and invitations simply expire."""
_JOINS_HZ: Final = 0.5
_JOINS_BURST: Final = 10
"""Per browser: joining an idle robot's queue and leaving it is a turn, which all are told."""
_MOST_JOINING: Final = 1000
_JOINS_TOO_OFTEN: Final = Sentence("queue.too_often")
_NO_TAPE: Final = Sentence("tape.none")


class Room:
    """The viewers, their peers and their queue; call all methods from the event loop."""

    def __init__(
        self,
        *,
        settings: Settings,
        clock: Clock,
        counters: Counters,
        service: Service,
        turns: Turns,
        viewers: Viewers,
        control: ControlLoop,
        page_messages: PageMessages,
        keeper: RecordKeeper,
        network: Network,
        access: Access,
        decisions: HostDecisions,
        kept: KeptFile,
        records: Records,
        cluster: Cluster,
        has_time: Callable[[int], bool],
        voices: Voices | None = None,
        tape: TapeKeeper | None = None,
    ) -> None:
        self._settings = settings
        self._tape = tape
        self._network = network
        self._clock = clock
        self._counters = counters
        self._service = service
        self._turns = turns
        self._viewers = viewers
        self._page_messages = page_messages
        self._control = control
        self._access = access
        self._decisions = decisions
        self._kept = kept
        self._stops = StopBudget(
            settings=settings.stop,
            clock=clock,
            decisions=decisions,
            turns=turns,
            control=control,
            keeper=keeper,
            save=self._save,
            watching=self._watches_from,
        )
        self._host_acts = HostActs(
            clock=clock,
            access=access,
            decisions=decisions,
            turns=turns,
            control=control,
            viewers=viewers,
            records=records,
            room=self,
            stops=self._stops,
            event_maker=keeper.event_maker,
            public_url=settings.server.public_url,
        )
        self._entry = Entry(
            settings=settings,
            clock=clock,
            counters=counters,
            service=service,
            network=network,
            access=access,
            viewers=viewers,
            events=self,
            drop_peer=self._drop_peer,
            send_away=self.send_away,
            is_due=self._is_due,
            has_time=has_time,
            voices=voices,
        )
        self._voices = voices
        self._rooms = Rooms(
            settings=settings.server,
            clock=clock,
            cluster=cluster,
            access=access,
            viewers=viewers,
            turns=turns,
            control=control,
            entry=self._entry,
            page_messages=page_messages,
            wait=self._waits_in_room,
            join=self._join,
            forget=self._forget,
            lost_after_s=_LOST_S,
        )
        cluster.broadcast(self._message_for_rooms)
        self._joins = TokenBuckets(rate_hz=_JOINS_HZ, burst=_JOINS_BURST, most=_MOST_JOINING)
        self._gone_since_s: dict[int, float] = {}
        self._is_closing = False
        self._updates = RoomUpdates(clock.now_s())
        self._polled_s = 0.0
        self._told_problem: Sentence | None = None
        self._checked_s = 0.0
        self._take_over(kept.before)

    # --- over a restart --------------------------------------------------------------------

    def resume(self) -> None:
        """Restore the Stop that was in force when the last server ended; needs the driver."""
        before = self._kept.before
        if in_force := before.model_dump(exclude_defaults=True):
            _LOG.info("in force since before the restart", **in_force)
        if before.stop is not None:
            self._stops.restore(before.stop)

    def _take_over(self, kept: KeptState) -> None:
        self._decisions.is_blanked = kept.is_blanked
        self._decisions.are_voices_muted = kept.are_voices_muted
        self._decisions.max_fraction = kept.max_fraction
        self._access.admission.is_locked = kept.is_locked
        self._access.admission.is_closed = kept.is_closed
        self._access.admission.closed_until_s = kept.closed_until_s
        if kept.is_held:
            self._control.hold_queue(is_held=True)

    def _save(self) -> None:
        admission, decisions = self._access.admission, self._decisions
        self._kept.save(
            KeptState(
                stop=self._stops.in_force,
                is_held=self._turns.is_held,
                is_blanked=decisions.is_blanked,
                are_voices_muted=decisions.are_voices_muted,
                max_fraction=decisions.max_fraction,
                is_locked=admission.is_locked,
                is_closed=admission.is_closed,
                closed_until_s=admission.closed_until_s,
            )
        )

    # --- admission -------------------------------------------------------------------------

    async def answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        """Answer a page's offer; see `Entry.answer`."""
        if self._is_closing:
            raise FullError(_GOODBYE)
        return await self._entry.answer(visitor, tab, offer)

    @property
    def rooms(self) -> Rooms:
        """The people who watch in LiveKit rooms."""
        return self._rooms

    # --- viewers' events (ViewerEvents) ----------------------------------------------------

    def viewer_connected(self, viewer: Viewer) -> None:
        _LOG.info("viewer connected", viewer=viewer.number)
        self._entry.connected(viewer.number)
        viewer.send(
            self._page_messages.hello(
                viewer.number, viewer.visitor, viewer.grant, lost_after_s=_LOST_S
            )
        )
        self._control.connect(viewer.number, _person(viewer))
        if (told := self._updates.told) is not None:
            # The next change builds on that state; the viewer's own line comes at once.
            viewer.send(told)
            own = self._page_messages.line(viewer, self._clock.now_s())
            viewer.send_text(room_change.text_of(room_change.of_lines([own])))
        self._viewers.changed()

    def viewer_changed_network(self, viewer: Viewer) -> None:
        """Let an operator drive on, but only by a new press, as after any other loss."""
        self._control.lost(viewer.number)
        self._control.returned(viewer.number)

    def viewer_closed(self, viewer: Viewer, peer: Peer) -> None:
        if peer is not viewer.peer:
            return
        # A viewer who never connected may be one of a flood, which must not fill the log.
        log = _LOG.info if viewer.was_ready else _LOG.debug
        log("viewer's peer closed", viewer=viewer.number)
        self._drop_peer(viewer)
        if not viewer.was_ready:
            self._forget(viewer)

    def viewer_role(self, viewer: Viewer) -> Role:
        """Return a viewer's current role."""
        if viewer.visitor.is_embed:
            return "embed"
        if viewer.visitor.is_host:
            return "host"
        if viewer.number != self._turns.operator:
            return "observer"
        return "adviser" if self._control.is_taken else "operator"

    def viewer_wants_name(self, viewer: Viewer, name: str) -> None:
        others = (
            one.name for one in self._viewers if one.visitor.identity != viewer.visitor.identity
        )
        robot = self._settings.page.name
        why = None if not name or viewer.visitor.is_host else names.refusal(name, others, robot)
        if why is None:
            viewer.name = name or f"Guest {viewer.number}"
            self._viewers.changed()
        else:
            viewer.send(messages.Notice(text=why))

    def viewer_asks(self, viewer: Viewer, request: Request) -> None:
        with self._refusing(viewer):
            match request:
                case messages.Join():
                    self._join(viewer)
                case messages.Leave():
                    self._control.leave(viewer.number)
                case messages.Here():
                    self._control.answer_call(viewer.number)
                case messages.KeepTape():
                    self._keep_tape(viewer)

    def _keep_tape(self, viewer: Viewer) -> None:
        if self._tape is None:
            raise ForbiddenError(_NO_TAPE)
        viewer.send(messages.Notice(text=self._tape.keep(self.viewer_role(viewer))))

    def viewer_acts(self, viewer: Viewer, act: messages.HostIn) -> None:
        try:
            self._host_acts.handle(viewer, act)
        finally:
            self._save()

    def viewer_stops(self, viewer: Viewer, press: int | None) -> None:
        with self._refusing(viewer):
            self._stops.press(viewer, press, is_host=viewer.visitor.is_host)

    def viewer_releases(self, viewer: Viewer, release: messages.Release) -> None:
        with self._refusing(viewer):
            sent_s = viewer.release_sent_s(release)
            self._stops.release(viewer, release.stop, sent_s, is_host=viewer.visitor.is_host)

    def viewer_drives(self, viewer: Viewer, command: Command) -> None:
        self._control.handle_command(viewer.number, command)

    def viewer_operates(self, viewer: Viewer, asked: Operation) -> Refusal | None:
        refusal = self._control.operate(
            viewer.number,
            asked,
            is_host=viewer.visitor.is_host,
            one_way_s=viewer.link.one_way_s,
        )
        if refusal is None and asked.wanted:
            self._viewers.changed()
        return refusal

    # --- by HTTP ---------------------------------------------------------------------------

    def role_of(self, visitor: Visitor) -> Role:
        """Return a browser's current role, the highest of its viewers' roles."""
        if visitor.is_host:
            return "host"
        viewer = self._acting(visitor, None)
        if viewer is None:
            return "observer" if self._rooms.has_seat(visitor) else "stranger"
        return self.viewer_role(viewer)

    def by_tab(self, visitor: Visitor, tab: str) -> Visitor:
        """Return the guest, here or in a room, whose tab has this secret; else the visitor.

        Embeds have no tab secret, and a secret alone makes nobody the host.
        """
        viewer = self._viewers.of_secret(tab)
        found = self._rooms.of_tab(tab) if viewer is None else viewer.visitor
        return visitor if found is None or found.is_host else found

    def has_people_at(self, address: str) -> bool:
        """Whether somebody at this address watches, here or in a LiveKit room."""
        return bool(self._watches_from(address))

    def file_sent(self, visitor: Visitor, size_bytes: int) -> float | None:
        """Count a piece of a file; return the longest pause that `Streams.file_sent` asks for."""
        own = self._viewers.of_identity(visitor.identity)
        waits_s = [one.streams.file_sent(size_bytes) for one in own if one.peer is not None]
        return max((one for one in waits_s if one is not None), default=None)

    def stop_by(self, visitor: Visitor, tab: str | None, press: int | None = None) -> int:
        """Latch the Stop before anything else; returns its number. Raises `ForbiddenError`."""
        viewer = self._acting(visitor, tab)
        if viewer is None and not visitor.is_host and self._rooms.has_seat(visitor):
            number = self._stops.press_from_room(visitor, press)
        else:
            number = self._stops.press(viewer, press, is_host=visitor.is_host)
        self._viewers.changed()
        return number

    def release_by(self, visitor: Visitor, tab: str | None, stop: int) -> None:
        """Release the stop with this number; raises `ForbiddenError`."""
        viewer = self._acting(visitor, tab)
        self._stops.release(viewer, stop, None, is_host=visitor.is_host)
        self._viewers.changed()

    def house_acts(self, act: HouseAct) -> None:
        """Carry out an act of the host's home automation; raises `ForbiddenError` if it may not."""
        check("house", messages.Release if isinstance(act, ReleaseAt) else type(act))
        match act:
            case messages.Stop():
                self._stops.press_from_house()
            case ReleaseAt():
                if not self._settings.mqtt.release:
                    raise ForbiddenError(Sentence("may.operator"))
                self._stops.release_from_house((self._clock.wall_ms() - act.wall_ms) / 1000)
            case _:
                try:
                    self._host_acts.handle_from_house(act)
                finally:
                    self._save()
        self._viewers.changed()

    def _watches_from(self, address: str) -> dict[str, float]:
        """Return since when each browser at an address has watched, here or in a LiveKit room."""
        since_s = self._rooms.since_s(address)
        for one in self._viewers:
            if one.was_ready and one.visitor.address == address and not one.visitor.is_embed:
                who = one.visitor.identity
                since_s[who] = min(one.since_s, since_s.get(who, one.since_s))
        return since_s

    def _acting(self, visitor: Visitor, tab: str | None) -> Viewer | None:
        """Return the viewer behind a request: the operator if this browser drives, else the tab."""
        own = self._viewers.of_identity(visitor.identity)
        drives = next((one for one in own if one.number == self._turns.operator), None)
        return drives or self._viewers.of_tab(visitor.identity, tab) or next(iter(own), None)

    # --- for the host (RoomForHost) ---------------------------------------------------------

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
        self._forget(viewer)
        if peer is not None:
            # Later, because the message must be sent before the channel closes.
            asyncio.get_running_loop().call_later(_GOODBYE_S, peer.abandon)

    def check_all(self) -> None:
        """Soon send away everybody who may no longer stay, and update the others' rights."""
        in_batches([partial(self._check, viewer) for viewer in self._viewers])

    def _check(self, viewer: Viewer) -> None:
        if self._viewers.numbered(viewer.number) is None:
            return  # gone since this was scheduled
        visitor = self._access.refreshed(viewer.visitor)
        if viewer.visitor.is_host and not visitor.is_host:
            viewer.visitor = visitor
            self.send_away(viewer, SIGNED_OUT)
            return
        try:
            grant = self._access.admit(visitor)
        except NotAdmittedError as error:
            self.send_away(viewer, error.sentence, error.openings)
        else:
            viewer.update_access(visitor, grant)
            self._control.update_person(viewer.number, _person(viewer))

    def check_rooms(self) -> None:
        """Soon do the same for everybody who watches in a LiveKit room."""
        self._rooms.check_all()

    def _join(self, viewer: Viewer) -> None:
        """Put a viewer into the queue; raises `ForbiddenError` with the reason if it cannot."""
        joins = self._turns.place(viewer.number) is None
        if joins and not self._joins.take(viewer.visitor.identity, self._clock.now_s()):
            raise ForbiddenError(_JOINS_TOO_OFTEN)
        refusal = self._control.join(viewer.number)
        if refusal is not None:
            raise ForbiddenError(refusal)

    def _waits_in_room(self, viewer: Viewer) -> None:
        self._control.connect(viewer.number, _person(viewer), is_here=False)

    @contextmanager
    def _refusing(self, viewer: Viewer) -> Iterator[None]:
        """Send a viewer the reason when their request is refused."""
        try:
            yield
        except ForbiddenError as error:
            self._counters.add("requests refused")
            viewer.send(messages.Notice(text=error.sentence))
        self._viewers.changed()

    def _drop_peer(self, viewer: Viewer) -> None:
        """Drop a viewer's peer: the robot stops if they drove; they keep their place for now."""
        viewer.peer = None
        with viewer.boundary:
            viewer.release()
        now_s = self._clock.now_s()
        self._control.lost(viewer.number)
        if viewer.is_in_room(now_s):  # their page announced it before it disconnected
            self._waits_in_room(viewer)
        else:
            self._gone_since_s[viewer.number] = now_s
        self._viewers.changed()

    # --- housekeeping ----------------------------------------------------------------------

    async def run(self) -> None:
        """Detect lost links and send everybody what has changed, until cancelled."""
        while True:
            await asyncio.sleep(_ROUND_S)
            for _ in self.round(self._clock.now_s()):
                await asyncio.sleep(0)

    def round(self, now_s: float) -> Iterator[None]:
        """Run one round in short steps; rounds come at a fixed rate, whatever happens in them."""
        self._sweep(now_s)
        yield
        self._rooms.round(now_s)
        in_batches([partial(_run_deferred, viewer, now_s) for viewer in self._viewers])
        renamed = [viewer for viewer in self._viewers if viewer.has_name_waiting]
        in_batches([partial(_run_deferred_name, viewer, now_s) for viewer in renamed], portion=1)
        if self._voices is not None:
            self._voices.send_changes(now_s)
        yield
        if now_s - self._checked_s >= _CHECK_S:
            self._checked_s = now_s
            self.check_all()
            self._send_console()
            yield
        # First, or a Stop would shift the page's layout, and its paused clock a second time.
        self._control.tick_turns()
        problem = self._control.robot_state.said
        is_news = self._viewers.take_change() or problem != self._told_problem
        if is_news or now_s - self._polled_s >= _POLL_S:
            self._polled_s, self._told_problem = now_s, problem
            # Not `now_s`, which is older than the turn's clock.
            yield from self._send_changes(self._clock.now_s())

    def snapshot(self, now_s: float) -> messages.RoomState:
        """Return the state of the room for everybody."""
        return self._page_messages.room(
            self._viewers,
            self._control.robot_state,
            self._control.latched,
            now_s,
            first_axes=self._control.first_axes,
            controls=self._control.control_values,
        )

    def _send_console(self) -> None:
        """Send the hosts what only they see."""
        hosts = [one for one in self._viewers if one.visitor.is_host and one.is_ready]
        if not hosts:
            return
        lines: list[messages.ConsoleViewer] = []

        def add(viewer: Viewer) -> None:
            with viewer.boundary:
                lines.append(self._page_messages.console_line(viewer))

        def send() -> None:
            console = self._page_messages.console(lines, self._stops.pressers())
            text = console.model_dump_json()
            for host in hosts:
                host.send_text(text)

        in_batches([*(partial(add, viewer) for viewer in self._viewers), send])

    async def close(self) -> None:
        """Say goodbye to every page and close its peer; nobody is admitted any more."""
        self._is_closing = True
        for viewer in self._viewers:
            viewer.send(messages.Goodbye(text=_GOODBYE))
        if len(self._viewers) > 0:
            await asyncio.sleep(_GOODBYE_S)
        await asyncio.gather(*(viewer.close() for viewer in self._viewers))

    def _sweep(self, now_s: float) -> None:
        for viewer in self._viewers:
            if viewer.is_in_room(now_s):
                continue
            if viewer.peer is None:
                if not self._turns.is_lost(viewer.number):  # their page has stopped renewing
                    self._control.lost(viewer.number)
                since_s = self._gone_since_s.setdefault(viewer.number, now_s)
                if now_s - since_s >= self._settings.turns.grace_s:
                    self._forget(viewer)
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
        return _LOST_S if viewer.number == self._turns.operator else _OTHERS_LOST_S

    def _forget(self, viewer: Viewer) -> None:
        log = _LOG.info if viewer.was_ready else _LOG.debug
        log("viewer gone", viewer=viewer.number)
        self._viewers.remove(viewer)
        self._gone_since_s.pop(viewer.number, None)
        self._control.gone(viewer.number)

    def _send_changes(self, now_s: float) -> Iterator[None]:
        room = self.snapshot(now_s)
        yield
        update = self._updates.next(room, now_s)
        if update is None:
            return
        yield
        plain = for_guests(update)
        text = room_change.text_of(plain)
        for_host = text if plain == update else room_change.text_of(update)
        # A viewer who connects meanwhile already has the whole state, and gets some of it twice.
        in_batches(
            [partial(_send, viewer, text, for_host) for viewer in self._viewers if viewer.is_ready]
        )

    def _is_due(self, viewer: Viewer) -> bool:
        return self._rooms.is_due(viewer)

    def _message_for_rooms(self) -> str | None:
        now_s = self._clock.now_s()
        return self._rooms.message(self.snapshot(now_s), now_s)


def _run_deferred(viewer: Viewer, now_s: float) -> None:
    with viewer.boundary:
        viewer.run_deferred(now_s)


def _run_deferred_name(viewer: Viewer, now_s: float) -> None:
    with viewer.boundary:
        viewer.run_deferred_name(now_s)


def _send(viewer: Viewer, text: str, for_host: str) -> None:
    viewer.send_text(for_host if viewer.knows_faults else text)


def _person(viewer: Viewer) -> Person:
    visitor = viewer.visitor
    may_queue = viewer.grant.queue and not visitor.is_embed
    return Person(visitor.identity, visitor.address, visitor.invited_to is not None, may_queue)
