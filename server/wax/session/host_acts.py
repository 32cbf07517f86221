"""What the host does, on a page or by home automation; each act is logged and recorded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

import structlog

from wax.access.admission import BANNED
from wax.logs.printable import printable
from wax.protocol import messages
from wax.protocol.events import Removed
from wax.protocol.host_switches import Close, HoldQueue, Lock, SwitchAct
from wax.records.entries import RecordedPerson
from wax.sentence import Sentence
from wax.session.stop_budget import HOUSE

if TYPE_CHECKING:
    from wax.session.parts import Parts
    from wax.session.presence import Presence
    from wax.session.stop_budget import StopBudget
    from wax.session.viewer import Viewer

_LOG = structlog.get_logger(__name__)

REMOVED: Final = Sentence("door.removed")
_MAX_MESSAGE_CHARS: Final = 200


class HostActs:
    """Carries out the messages that only the host may send."""

    def __init__(self, parts: Parts, stops: StopBudget, presence: Presence) -> None:
        self._clock = parts.clock
        self._access = parts.access
        self._decisions = parts.decisions
        self._turns = parts.turns
        self._control = parts.control
        self._viewers = parts.viewers
        self._records = parts.records
        self._event_maker = parts.keeper.event_maker
        self._public_url = parts.settings.server.public_url
        self._stops = stops
        self._presence = presence

    def handle(self, host: Viewer, act: messages.HostIn) -> None:
        """Carry out an act, and record it."""
        about = self._about(act)
        if isinstance(act, SwitchAct):
            self._switch(act)
        elif not self._change_admission(host, act):
            self._decide(act)
        self._viewers.changed()
        self._record(RecordedPerson(host.visitor.identity, host.name), act, about)

    def handle_from_house(self, act: SwitchAct) -> None:
        """Carry out an act of the host's home automation, and record it."""
        self._switch(act)
        self._record(RecordedPerson("", str(HOUSE)), act)

    def _switch(self, act: SwitchAct) -> None:
        """Set a switch, and do at once what follows from its new value."""
        self._decisions.switches = self._decisions.switches.after(act)
        match act:
            case HoldQueue():
                self._control.hold_queue(act.held)
            case Lock():
                self._check_all()
            case Close():
                self._access.close(act.closed)
                self._check_all()

    def _record(self, person: RecordedPerson, act: messages.HostIn, about: str = "") -> None:
        detail = act.model_dump_json(exclude={"type", "viewer"})
        _LOG.info("host's act", by=person.name, act=act.type, about=about, detail=detail)
        self._records.host_act(person, act.type, about=about, detail=detail)

    def _decide(self, act: messages.HostIn) -> None:
        match act:
            case messages.EndTurn():
                if act.turn == self._turns.number:
                    self._control.end_turn()
            case messages.Mute():
                self._mute(act)
            case messages.MuteAddress():
                self._stops.mute(act.presser, act.muted)
            case messages.Announce():
                ends_s = None if act.for_s is None else self._clock.now_s() + act.for_s
                self._decisions.message = printable(act.text.strip(), _MAX_MESSAGE_CHARS)
                self._decisions.message_ends_s = ends_s

    def _change_admission(self, host: Viewer, act: messages.HostIn) -> bool:
        """Carry out an act about who may be here; return False for any other."""
        match act:
            case messages.Remove():
                self._remove(host, act)
            case messages.Invite():
                self._invite(host, act)
            case messages.SignOutOthers():
                n = self._access.sign_out_others(host.visitor)
                self._check_all()
                host.send(messages.Notice(text=Sentence("host.signed_out_others", {"n": n})))
            case _:
                return False
        return True

    def _about(self, act: messages.HostIn) -> str:
        if not isinstance(act, messages.Remove | messages.Mute):
            return ""
        viewer = self._viewers.numbered(act.viewer)
        return "" if viewer is None else f"{viewer.number} {viewer.name}"

    def _remove(self, host: Viewer, act: messages.Remove) -> None:
        viewer = self._viewers.numbered(act.viewer)
        if viewer is None:
            return
        if viewer.visitor.is_host:
            host.send(messages.Notice(text=Sentence("host.stays")))
            return
        if act.ban:
            self._access.ban(viewer.visitor)
            self._presence.check_rooms()  # the ban covers their address
        kind: Literal["viewer.removed", "viewer.banned"]
        kind = "viewer.banned" if act.ban else "viewer.removed"
        self._event_maker.publish(Removed(type=kind, viewer=viewer.number, name=viewer.name))
        for one in self._viewers.of_identity(viewer.visitor.identity):
            self._presence.send_away(one, BANNED if act.ban else REMOVED)

    def _check_all(self) -> None:
        self._presence.check_all()
        self._presence.check_rooms()

    def _mute(self, act: messages.Mute) -> None:
        viewer = self._viewers.numbered(act.viewer)
        if viewer is None:
            return
        if act.muted:
            self._decisions.muted.add(viewer.visitor.identity)
        else:
            self._decisions.muted.discard(viewer.visitor.identity)

    def _invite(self, host: Viewer, act: messages.Invite) -> None:
        token, ends_s = self._access.invite(act.purpose, uses=act.uses, valid_s=act.valid_s)
        host.send(
            messages.InvitationLink(
                page=self._public_url,
                token=token,
                purpose=act.purpose,
                uses=act.uses,
                ends_wall_ms=ends_s * 1000,
            )
        )
