"""The room: admits viewers, notices when they are lost, and sends everybody its state."""

from __future__ import annotations

import asyncio
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

import structlog

from wax.access.permissions import check
from wax.errors import ForbiddenError, FullError
from wax.fanout.batches import in_batches
from wax.house.commands import ReleaseAt
from wax.protocol import messages, room_change
from wax.sentence import Sentence
from wax.session import names
from wax.session.diagnosis import for_guests
from wax.session.entry import Entry
from wax.session.followers import Followers
from wax.session.host_acts import HostActs
from wax.session.kept_state import KeptState
from wax.session.page_messages import PageMessages
from wax.session.presence import GOODBYE, Presence
from wax.session.roles import role_of
from wax.session.room_queue import RoomQueue
from wax.session.room_updates import RoomUpdates
from wax.session.rooms import Rooms
from wax.session.stop_budget import StopBudget

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.access.admission import Visitor
    from wax.access.permissions import Role
    from wax.control.controls import Operation
    from wax.control.gate import Command
    from wax.control.reasons import Refusal
    from wax.house.commands import HouseAct
    from wax.rtc.peer import Peer
    from wax.session.parts import Parts
    from wax.session.viewer import Request, Viewer

_LOG = structlog.get_logger(__name__)

_ROUND_S: Final = 0.05
_POLL_S: Final = 0.2
"""The robot and the sources have no callback for failures; they are polled this often."""
_CHECK_S: Final = 1.0
"""How often to check whether everybody may still stay: hours and invitations simply expire."""
_NO_TAPE: Final = Sentence("tape.none")


class Room:
    """The viewers, their peers and their queue; call all methods from the event loop.

    `rooms` has the people who watch in LiveKit rooms, `queue` is for those of them who wait.
    """

    def __init__(self, parts: Parts) -> None:
        self._settings = parts.settings
        self._clock = parts.clock
        self._counters = parts.counters
        self._turns = parts.turns
        self._viewers = parts.viewers
        self._control = parts.control
        self._followers = Followers(parts.viewers)
        parts.control.listen(self._followers)
        self._access = parts.access
        self._decisions = parts.decisions
        self._kept = parts.kept
        self._tape = parts.tape
        self._voices = parts.voices
        self._page_messages = PageMessages(parts)
        self.rooms = Rooms(parts, self._page_messages)
        self._presence = Presence(parts, self.rooms)
        self._entry = Entry(parts, self._presence, events=self)
        self.queue = RoomQueue(parts, self._page_messages, self._presence, self._entry)
        self._stops = StopBudget(parts, self._presence)
        self._host_acts = HostActs(parts, self._stops, self._presence)
        self._is_closing = False
        self._updates = RoomUpdates(self._clock.now_s())
        self._polled_s = 0.0
        self._told_problem: Sentence | None = None
        self._checked_s = 0.0
        parts.cluster.broadcast(self._message_for_rooms)
        self._take_over(parts.kept.before)

    # --- over a restart --------------------------------------------------------------------

    def resume(self) -> None:
        """Restore the Stop that was in force when the last server ended; needs the driver."""
        before = self._kept.before
        if in_force := before.model_dump(exclude_defaults=True):
            _LOG.info("in force since before the restart", **in_force)
        if before.stop is not None:
            with self._saving():
                self._stops.restore(before.stop)

    def _take_over(self, kept: KeptState) -> None:
        self._decisions.switches = kept.switches
        if kept.is_held:
            self._control.hold_queue(is_held=True)

    @contextmanager
    def _saving(self) -> Iterator[None]:
        """Afterwards save what must outlast a restart, if it has changed."""
        try:
            yield
        finally:
            self._save()

    def _save(self) -> None:
        switches = dict(self._decisions.switches)
        self._kept.save(KeptState(stop=self._stops.in_force, **switches))

    # --- admission -------------------------------------------------------------------------

    async def answer(self, visitor: Visitor, tab: str, offer: str) -> str:
        """Answer a page's offer; see `Entry.answer`."""
        if self._is_closing:
            raise FullError(GOODBYE)
        return await self._entry.answer(visitor, tab, offer)

    async def accept(self, visitor: Visitor, tab: str, answer: str) -> None:
        """Accept a page's answer to our offer; see `Entry.accept`."""
        await self._entry.accept(visitor, tab, answer)

    # --- viewers' events (ViewerEvents) ----------------------------------------------------

    def viewer_connected(self, viewer: Viewer) -> None:
        _LOG.info("viewer connected", viewer=viewer.number)
        self._entry.connected(viewer.number)
        viewer.send(self._page_messages.hello(viewer.number, viewer.visitor, viewer.grant))
        self._presence.connect(viewer)
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
        self._presence.drop_peer(viewer)
        if not viewer.was_ready:
            self._presence.forget(viewer)

    def viewer_role(self, viewer: Viewer) -> Role:
        """Return a viewer's current role."""
        return role_of(viewer, self._turns, self._control)

    def viewer_wants_name(self, viewer: Viewer, name: str) -> None:
        others = (
            one.name for one in self._viewers if one.visitor.identity != viewer.visitor.identity
        )
        if viewer.visitor.vouched is not None and viewer.visitor.vouched.name:
            return  # they are called what the proxy calls them
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
                    self._presence.join(viewer)
                case messages.Leave():
                    self._control.leave(viewer.number)
                case messages.Here():
                    self._control.answer_call(viewer.number)
                case messages.KeepTape() | messages.SetTask() | messages.Disown():
                    self._ask_tape(viewer, request)
                case messages.Follow():
                    self._followers.add(viewer)

    def _ask_tape(
        self, viewer: Viewer, request: messages.KeepTape | messages.SetTask | messages.Disown
    ) -> None:
        if self._tape is None:
            raise ForbiddenError(_NO_TAPE)
        match request:
            case messages.KeepTape():
                viewer.send(messages.Notice(text=self._tape.keep(self.viewer_role(viewer))))
            case messages.SetTask():
                self._tape.set_task(viewer.number, request)
            case messages.Disown():
                viewer.send(messages.Notice(text=self._tape.disown(viewer.number, request.turn)))

    def viewer_acts(self, viewer: Viewer, act: messages.HostIn) -> None:
        with self._saving():
            self._host_acts.handle(viewer, act)

    def viewer_stops(self, viewer: Viewer, press: int | None) -> None:
        with self._refusing(viewer), self._saving():
            self._stops.press(viewer, press, is_host=viewer.visitor.is_host)

    def viewer_releases(self, viewer: Viewer, release: messages.Release) -> None:
        with self._refusing(viewer), self._saving():
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
            return "observer" if self.rooms.has_seat(visitor) else "stranger"
        return self.viewer_role(viewer)

    def by_tab(self, visitor: Visitor, tab: str) -> Visitor:
        """Return the guest, here or in a room, whose tab has this secret; else the visitor.

        Embeds have no tab secret, and a secret alone makes nobody the host.
        """
        viewer = self._viewers.of_secret(tab)
        found = self.rooms.of_tab(tab) if viewer is None else viewer.visitor
        return visitor if found is None or found.is_host else found

    def renew(self, visitor: Visitor) -> None:
        """Note that a proxy has said anew who somebody is, which proves that they are signed in."""
        for viewer in self._viewers.of_identity(visitor.identity):
            if visitor.proves(viewer.visitor):
                self._presence.renew(viewer, visitor)
        self.rooms.renew(visitor)

    def has_people_at(self, address: str) -> bool:
        """Whether somebody at this address watches, here or in a LiveKit room."""
        return bool(self._presence.watches_from(address))

    def file_sent(self, visitor: Visitor, size_bytes: int) -> float | None:
        """Count a piece of a file; return the longest pause that `Streams.file_sent` asks for."""
        own = self._viewers.of_identity(visitor.identity)
        waits_s = [one.streams.file_sent(size_bytes) for one in own if one.peer is not None]
        return max((one for one in waits_s if one is not None), default=None)

    def stop_by(self, visitor: Visitor, tab: str | None, press: int | None = None) -> int:
        """Latch the Stop before anything else; returns its number. Raises `ForbiddenError`."""
        viewer = self._acting(visitor, tab)
        with self._saving():
            if viewer is None and not visitor.is_host and self.rooms.has_seat(visitor):
                number = self._stops.press_from_room(visitor, press)
            else:
                number = self._stops.press(viewer, press, is_host=visitor.is_host)
        self._viewers.changed()
        return number

    def release_by(self, visitor: Visitor, tab: str | None, stop: int) -> None:
        """Release the stop with this number; raises `ForbiddenError`."""
        viewer = self._acting(visitor, tab)
        with self._saving():
            self._stops.release(viewer, stop, None, is_host=visitor.is_host)
        self._viewers.changed()

    def house_acts(self, act: HouseAct) -> None:
        """Carry out an act of the host's home automation; raises `ForbiddenError` if it may not."""
        check("house", messages.Release if isinstance(act, ReleaseAt) else type(act))
        with self._saving():
            match act:
                case messages.Stop():
                    self._stops.press_from_house()
                case ReleaseAt():
                    if not self._settings.mqtt.release:
                        raise ForbiddenError(Sentence("may.operator"))
                    self._stops.release_from_house((self._clock.wall_ms() - act.wall_ms) / 1000)
                case _:
                    self._host_acts.handle_from_house(act)
        self._viewers.changed()

    def _acting(self, visitor: Visitor, tab: str | None) -> Viewer | None:
        """Return the viewer behind a request: the operator if this browser drives, else the tab."""
        own = self._viewers.of_identity(visitor.identity)
        drives = next((one for one in own if one.number == self._turns.operator), None)
        return drives or self._viewers.of_tab(visitor.identity, tab) or next(iter(own), None)

    @contextmanager
    def _refusing(self, viewer: Viewer) -> Iterator[None]:
        """Send a viewer the reason when their request is refused."""
        try:
            yield
        except ForbiddenError as error:
            self._counters.add("requests refused")
            viewer.send(messages.Notice(text=error.sentence))
        self._viewers.changed()

    # --- housekeeping ----------------------------------------------------------------------

    async def run(self) -> None:
        """Detect lost links and send everybody what has changed, until cancelled.

        While nobody is here or in a LiveKit room, one round a second does.
        """
        while True:
            await asyncio.sleep(_ROUND_S)
            now_s = self._clock.now_s()
            if len(self._viewers) or self.rooms.has_seats or now_s - self._checked_s >= _CHECK_S:
                for _ in self.round(now_s):
                    await asyncio.sleep(0)

    def round(self, now_s: float) -> Iterator[None]:
        """Run one round in short steps; rounds come at a fixed rate, whatever happens in them."""
        self._presence.sweep(now_s)
        yield
        self.rooms.round(now_s)
        in_batches([partial(_run_deferred, viewer, now_s) for viewer in self._viewers])
        renamed = [viewer for viewer in self._viewers if viewer.has_name_waiting]
        in_batches([partial(_run_deferred_name, viewer, now_s) for viewer in renamed], portion=1)
        if self._voices is not None:
            self._voices.send_changes(now_s)
        self._followers.send_changes()
        yield
        if now_s - self._checked_s >= _CHECK_S:
            self._checked_s = now_s
            self._presence.check_all()
            if self._settings.access.proxy.is_used and not self.rooms.is_checking:
                self._presence.check_rooms()
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
        return self._page_messages.room(now_s)

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
        await self._presence.close()

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

    def _message_for_rooms(self) -> str | None:
        now_s = self._clock.now_s()
        return self.rooms.message(self.snapshot(now_s), now_s)


def _run_deferred(viewer: Viewer, now_s: float) -> None:
    with viewer.boundary:
        viewer.run_deferred(now_s)


def _run_deferred_name(viewer: Viewer, now_s: float) -> None:
    with viewer.boundary:
        viewer.run_deferred_name(now_s)


def _send(viewer: Viewer, text: str, for_host: str) -> None:
    viewer.send_text(for_host if viewer.knows_faults else text)
