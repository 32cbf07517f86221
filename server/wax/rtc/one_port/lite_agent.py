"""One peer's ICE-lite agent (RFC 8445, 2.5), which checks each address that checks it. Pure.

A lite agent answers the browser's checks and sends to the address that the browser nominates. With
that alone, a viewer could forge a stranger's address on their checks and aim the video at it. So an
address gets only short answers until it has answered one check of ours.

A browser whose address changes keeps sending from the new one, but checks it only when its timer
fires, up to 2.5 s later. So authenticated data makes us check the address that it comes from.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from aioice.candidate import candidate_priority
from aioice.stun import Class, Message, Method

from wax.rate_limits import TokenBucket

MAX_PATHS: Final = 8
"""A browser has a few addresses; a longer list is an attack."""
_RETRY_S: Final = (0.1, 0.2, 0.4, 0.8)
"""Delays before an unanswered check of ours is retransmitted, each after the previous one."""
_SILENT_S: Final = 2.0
"""After this much silence, the selected address gives way to one that is heard."""
_QUIET_S: Final = 0.2
"""A browser silent for this long may have a new address; an operator sends ten times a second."""
_GIVE_UP_S: Final = 30.0
"""Consent expires this long after the last check from a verified address (RFC 7675, 5.1)."""
_PROBES_HZ: Final = 4.0
_PROBES_BURST: Final = 8.0
_USER_SEPARATOR: Final = ":"


class Path(NamedTuple):
    """A local socket, by its number, and a remote address and port."""

    socket: int
    host: str
    port: int


class Datagram(NamedTuple):
    """A datagram to send; `asks` is the transaction ID if it is a check of ours."""

    path: Path
    data: bytes
    asks: bytes | None = None


@dataclass(slots=True)
class _PathState:
    is_verified: bool = False
    is_nominated: bool = False
    probe: Message | None = None
    probes: int = 0
    probe_due_s: float = 0.0
    heard_s: float = field(default=float("-inf"))


class LiteAgent:
    """Holds both ends' credentials, and the paths on which the browser was heard."""

    def __init__(self, *, now_s: float) -> None:
        # Too long to be guessed, since it also selects the peer.
        self.username = secrets.token_hex(8)
        self.password = secrets.token_hex(16)
        self.remote_username: str | None = None
        self.remote_password: str | None = None
        self.selected: Path | None = None
        self._tie_breaker = secrets.randbits(64)
        self._paths: dict[Path, _PathState] = {}
        self._dropped: list[tuple[Path, bytes | None]] = []
        self._checked_s = now_s
        self._probes = TokenBucket(_PROBES_HZ, _PROBES_BURST)

    def note_datagram(self, path: Path, now_s: float) -> bool:
        """Note a datagram other than STUN; return whether its path is verified as the browser's."""
        state = self._paths.get(path)
        if state is None or not state.is_verified:
            return False
        state.heard_s = now_s
        if path != self.selected:
            self._select(path, now_s, is_nomination=False)
        return True

    def is_quiet(self, now_s: float) -> bool:
        """Whether the selected address has fallen silent, so that the browser may have moved."""
        state = None if self.selected is None else self._paths.get(self.selected)
        return state is not None and now_s - state.heard_s > _QUIET_S

    def note_authenticated(self, path: Path, now_s: float) -> list[Datagram]:
        """Handle a path on which authenticated data of the browser has arrived.

        The path counts as nominated, since browsers send data on no other. If it is not verified,
        it is checked.
        """
        state = self._state(path)
        if state.is_verified:
            if self.is_quiet(now_s):  # else the data was in flight when the browser moved
                self._select(path, now_s, is_nomination=True)
            return []
        state.heard_s = now_s
        state.is_nominated = True
        return [] if state.probe else self._probe(path, state, now_s)

    def is_lost(self, now_s: float) -> bool:
        """Whether consent has expired: no verified address has checked us for `_GIVE_UP_S`."""
        return now_s - self._checked_s > _GIVE_UP_S

    @property
    def is_asking(self) -> bool:
        """Whether a check of ours is still unanswered."""
        return any(state.probe is not None for state in self._paths.values())

    def refuse(self, path: Path) -> None:
        """Forget a path that is another peer's."""
        if path in self._paths:
            self._drop(path)

    def take_dropped(self) -> list[tuple[Path, bytes | None]]:
        """Return the paths dropped since the last call, each with the ID of its pending check."""
        dropped, self._dropped = self._dropped, []
        return dropped

    def handle_request(self, request: Message, path: Path, now_s: float) -> list[Datagram]:
        """Answer a check; one that is not signed with our password gets no answer."""
        if self.remote_username is None or not self._is_for_us(request):
            return []
        state = self._state(path)
        if now_s - state.heard_s > _GIVE_UP_S:
            state.is_verified = False  # a router may have given it to somebody else meanwhile
        if state.is_verified:
            self._checked_s = now_s  # other addresses must not prolong consent for an old one
        state.heard_s = now_s
        state.is_nominated = state.is_nominated or "USE-CANDIDATE" in request.attributes
        out = [Datagram(path, self._answer(request, path))]
        if state.is_verified:
            self._select(path, now_s, is_nomination="USE-CANDIDATE" in request.attributes)
        elif state.probe is None:
            out += self._probe(path, state, now_s)
        return out

    def handle_response(self, response: Message, path: Path, now_s: float) -> bool:
        """Handle a response to a check of ours; return whether it verifies the path."""
        state = self._paths.get(path)
        if state is None or state.probe is None or self.remote_password is None:
            return False
        if response.transaction_id != state.probe.transaction_id:
            return False
        if response.message_class != Class.RESPONSE:
            return False
        if not response.check_message_integrity(self.remote_password.encode()):
            return False
        state.probe = None
        state.is_verified = True
        state.heard_s = self._checked_s = now_s
        self._select(path, now_s, is_nomination=state.is_nominated)
        return True

    def tick(self, now_s: float) -> list[Datagram]:
        """Retransmit unanswered checks, and drop addresses that never answer."""
        out: list[Datagram] = []
        for path, state in list(self._paths.items()):
            if state.probe is None or now_s < state.probe_due_s:
                continue
            if state.probes > len(_RETRY_S):
                self._drop(path)
            else:
                out += self._probe(path, state, now_s)
        return out

    def _is_for_us(self, request: Message) -> bool:
        if request.message_method != Method.BINDING or request.message_class != Class.REQUEST:
            return False
        wanted = f"{self.username}{_USER_SEPARATOR}{self.remote_username}"
        return request.attributes.get("USERNAME") == wanted and request.check_message_integrity(
            self.password.encode()
        )

    def _answer(self, request: Message, path: Path) -> bytes:
        answer = Message(Method.BINDING, Class.RESPONSE, request.transaction_id)
        answer.attributes["XOR-MAPPED-ADDRESS"] = (path.host, path.port)
        answer.add_message_integrity(self.password.encode())
        return bytes(answer)

    def _probe(self, path: Path, state: _PathState, now_s: float) -> list[Datagram]:
        """Check a path within the peer's rate limit: each check may go to a stranger."""
        assert self.remote_password is not None
        if not self._probes.take(now_s):
            return []
        if state.probe is None:
            state.probe = Message(Method.BINDING, Class.REQUEST)
            state.probe.attributes["USERNAME"] = (
                f"{self.remote_username}{_USER_SEPARATOR}{self.username}"
            )
            state.probe.attributes["PRIORITY"] = candidate_priority(1, "prflx")
            state.probe.attributes["ICE-CONTROLLED"] = self._tie_breaker
            state.probe.add_message_integrity(self.remote_password.encode())
        state.probe_due_s = now_s + _RETRY_S[min(state.probes, len(_RETRY_S) - 1)]
        state.probes += 1
        return [Datagram(path, bytes(state.probe), state.probe.transaction_id)]

    def _select(self, path: Path, now_s: float, *, is_nomination: bool) -> None:
        current = None if self.selected is None else self._paths.get(self.selected)
        if is_nomination or current is None or now_s - current.heard_s > _SILENT_S:
            self.selected = path

    def _state(self, path: Path) -> _PathState:
        if path not in self._paths:
            if len(self._paths) >= MAX_PATHS:
                self._make_room()
            self._paths[path] = _PathState()
        return self._paths[path]

    def _make_room(self) -> None:
        """Drop an unverified address, or else the one that has been silent for longest."""
        self._drop(
            min(
                (path for path in self._paths if path != self.selected),
                key=lambda path: (self._paths[path].is_verified, self._paths[path].heard_s),
            )
        )

    def _drop(self, path: Path) -> None:
        probe = self._paths.pop(path).probe
        self._dropped.append((path, None if probe is None else probe.transaction_id))
        if self.selected == path:
            self.selected = None
