"""One peer's side of ICE-lite (RFC 8445, 2.5), which checks each address that checks it. Pure.

A lite agent answers the browser's checks and sends to the address that the browser nominates. By
that alone, a viewer who writes a stranger's address on their checks would aim the video at it. So
an address gets nothing but a short answer until it has answered one check of ours.

A browser that gets another address goes on sending from there, but checks it only when its timer is
due, 2.5 s later at worst. So what it has encrypted makes us check the address from which it comes.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from aioice.candidate import candidate_priority
from aioice.stun import Class, Message, Method

MAX_PATHS: Final = 8
"""A browser has a few addresses; more are a stranger's list."""
_RETRY_S: Final = (0.1, 0.2, 0.4, 0.8)
"""When an unanswered check of ours is sent again, after the one before."""
_SILENT_S: Final = 2.0
"""A nominated address that is silent for so long gives way to another that is not."""
_QUIET_S: Final = 0.2
"""Whoever is not heard for so long may have another address; an operator is ten times a second."""
_GIVE_UP_S: Final = 30.0
"""Consent ends for so long without a check from where the browser has answered (RFC 7675, 5.1)."""
_PROBES_HZ: Final = 4.0
_PROBES_BURST: Final = 8.0
_USER_SEPARATOR: Final = ":"


class Path(NamedTuple):
    """A local socket, by its number, and a remote address and port."""

    socket: int
    host: str
    port: int


class Datagram(NamedTuple):
    """What is to be sent; `asks` is the transaction of a check of ours."""

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
    """Knows both ends' credentials, and the paths by which the browser was heard."""

    def __init__(self, *, now_s: float) -> None:
        # Long enough that nobody finds one by trying, since it also selects the peer.
        self.username = secrets.token_hex(8)
        self.password = secrets.token_hex(16)
        self.remote_username: str | None = None
        self.remote_password: str | None = None
        self.selected: Path | None = None
        self._tie_breaker = secrets.randbits(64)
        self._paths: dict[Path, _PathState] = {}
        self._dropped: list[tuple[Path, bytes | None]] = []
        self._checked_s = now_s
        self._probes_left = _PROBES_BURST
        self._filled_s = now_s

    def heard(self, path: Path, now_s: float) -> bool:
        """Note a datagram that is no STUN; whether the path is the browser's."""
        state = self._paths.get(path)
        if state is None or not state.is_verified:
            return False
        state.heard_s = now_s
        if path != self.selected:
            self._select(path, now_s, is_nomination=False)
        return True

    def is_quiet(self, now_s: float) -> bool:
        """Whether nothing comes from where the browser was, so that it may be elsewhere."""
        state = None if self.selected is None else self._paths.get(self.selected)
        return state is not None and now_s - state.heard_s > _QUIET_S

    def spoke(self, path: Path, now_s: float) -> list[Datagram]:
        """Handle a path by which something came that only the browser can have encrypted.

        It counts as nominated, since browsers send data by no other. One that has not answered a
        check of ours is sent one.
        """
        state = self._state(path)
        if state.is_verified:
            if self.is_quiet(now_s):  # else it was under way when the browser moved
                self._select(path, now_s, is_nomination=True)
            return []
        state.heard_s = now_s
        state.is_nominated = True
        return [] if state.probe else self._probe(path, state, now_s)

    def is_lost(self, now_s: float) -> bool:
        """Whether nobody consents: no address that has answered has checked us for so long."""
        return now_s - self._checked_s > _GIVE_UP_S

    @property
    def is_asking(self) -> bool:
        """Whether a check of ours is not answered yet."""
        return any(state.probe is not None for state in self._paths.values())

    def refuse(self, path: Path) -> None:
        """Forget a path that is another peer's."""
        if path in self._paths:
            self._drop(path)

    def take_dropped(self) -> list[tuple[Path, bytes | None]]:
        """Return the paths dropped since the last call, with their checks that wait."""
        dropped, self._dropped = self._dropped, []
        return dropped

    def requested(self, request: Message, path: Path, now_s: float) -> list[Datagram]:
        """Answer a check; what is not signed with our password gets no answer."""
        if self.remote_username is None or not self._is_for_us(request):
            return []
        state = self._state(path)
        if now_s - state.heard_s > _GIVE_UP_S:
            state.is_verified = False  # a router may have given it to somebody else meanwhile
        if state.is_verified:
            self._checked_s = now_s  # else whoever left an address could keep us sending there
        state.heard_s = now_s
        state.is_nominated = state.is_nominated or "USE-CANDIDATE" in request.attributes
        out = [Datagram(path, self._answer(request, path))]
        if state.is_verified:
            self._select(path, now_s, is_nomination="USE-CANDIDATE" in request.attributes)
        elif state.probe is None:
            out += self._probe(path, state, now_s)
        return out

    def answered(self, response: Message, path: Path, now_s: float) -> bool:
        """Handle the answer to a check of ours; whether the path is verified by it."""
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
        """Send unanswered checks again, and forget addresses that never answer."""
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
        """Check a path, as often as the peer's budget allows: it costs a stranger a datagram."""
        assert self.remote_password is not None
        gained = (now_s - self._filled_s) * _PROBES_HZ
        self._probes_left = min(_PROBES_BURST, self._probes_left + gained)
        self._filled_s = now_s
        if self._probes_left < 1:
            return []
        self._probes_left -= 1
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
        """Forget an address that has not answered, else the one that is silent for longest."""
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
