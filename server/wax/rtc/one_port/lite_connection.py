"""A peer on the shared port: aiortc's ICE transport uses it in place of `aioice.Connection`."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Final

from aioice import Candidate, ConnectionClosed
from aioice.candidate import candidate_foundation, candidate_priority

from wax.rtc.one_port.lite_agent import LiteAgent, Path

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioice.stun import Message

    from wax.edge.turnstile import Meter
    from wax.rtc.one_port.lite_agent import Datagram
    from wax.rtc.one_port.udp_hub import UdpHub

_CONNECT_S: Final = 10.0
_TICK_S: Final = 0.05
_SLOW_TICK_S: Final = 1.0
_MAX_WAITING: Final = 128
"""Datagrams that DTLS has not read yet: those of the longest message, 64 KiB, and as many again. A
flood displaces the oldest, which are worth the least."""
_ENOUGH: Final = 16
"""With this many queued, the rest waits in this peer's own kernel queue, if it has one."""
_STEP_S: Final = 0.0005
"""Time per pass of the event loop for one peer's datagrams, so that a flood delays nobody. A pass
reads at least one."""
_STEP_SHARE: Final = 0.1
"""In a long pass a peer gets this part of it. With less, an operator whose datagrams arrive faster
than that is read ever later while the loop is busy: each command is too old, and the robot stands
although the loop still has time."""


class LiteConnection:
    """The part of `aioice.Connection` that aiortc uses, with aioice's names.

    `announced` returns this machine's public addresses, offered besides its own (1:1 NAT).
    `on_moved` is called when the browser is reached at a new address.
    """

    is_lite = True

    def __init__(
        self,
        hub: UdpHub,
        announced: Callable[[], Sequence[str]],
        now_s: Callable[[], float],
        meter: Meter,
        on_moved: Callable[[], None] = lambda: None,
    ) -> None:
        self.meter = meter
        self._on_moved = on_moved
        self._hub = hub
        self._announced = announced
        self._now_s = now_s
        self._agent = LiteAgent(now_s=now_s())
        self._queue: asyncio.Queue[tuple[bytes, Path | None] | None] = asyncio.Queue(_MAX_WAITING)
        self._step_began_s, self._step_s = 0.0, _STEP_S
        self._stray: Path | None = None
        """The path of the datagram that `recv` returned last, if it was not the selected one."""
        self._reached: Path | None = None
        self._decided = asyncio.Event()
        self._closed = asyncio.Event()
        self._timer: asyncio.TimerHandle | None = None
        self._local: list[Candidate] = []
        self._remote: list[Candidate] = []
        self._may_segment = True
        # Set by aiortc; a lite agent is always controlled.
        self.ice_controlling = False
        self.remote_is_lite = False

    # --- what aiortc reads and sets ----------------------------------------------------------

    @property
    def local_username(self) -> str:
        return self._agent.username

    @property
    def local_password(self) -> str:
        return self._agent.password

    @property
    def local_candidates(self) -> list[Candidate]:
        return list(self._local)

    @property
    def remote_candidates(self) -> list[Candidate]:
        return list(self._remote)

    @property
    def remote_username(self) -> str | None:
        return self._agent.remote_username

    @remote_username.setter
    def remote_username(self, value: str | None) -> None:
        self._agent.remote_username = value

    @property
    def remote_password(self) -> str | None:
        return self._agent.remote_password

    @remote_password.setter
    def remote_password(self, value: str | None) -> None:
        self._agent.remote_password = value

    async def gather_candidates(self) -> None:
        """Offer the shared port on each address, and start answering checks."""
        addresses = await self._hub.rebind()
        if self._closed.is_set():
            return
        self._hub.add(self._agent.username, self)
        everywhere = dict.fromkeys([*addresses, *self._announced()])
        self._local = [
            Candidate(
                foundation=candidate_foundation("host", "udp", host),
                component=1,
                transport="udp",
                priority=candidate_priority(1, "host", 65535 - number),
                host=host,
                port=self._hub.port,
                type="host",
            )
            for number, host in enumerate(everywhere)
        ]

    async def add_remote_candidate(self, candidate: Candidate | None) -> None:
        """Store the candidate only: a lite agent checks no address that has not checked it."""
        if candidate is not None:
            self._remote.append(candidate)

    async def connect(self) -> None:
        """Wait for a verified address of the browser; raises `ConnectionError` after 10 s."""
        self._tick()
        try:
            async with asyncio.timeout(_CONNECT_S):
                await self._decided.wait()
        except TimeoutError:
            self._end()
        if self._closed.is_set():
            raise ConnectionError("no check of the browser's has come through")

    async def close(self) -> None:
        """Stop answering; safe to call twice."""
        self._end()

    async def get_event(self) -> ConnectionClosed | None:
        await self._closed.wait()
        return ConnectionClosed()

    async def recv(self) -> bytes:
        """Return the next datagram; raises `ConnectionError` once closed."""
        is_next = not self._queue.empty()
        if is_next and time.thread_time() - self._step_began_s >= self._step_s:
            paused_s = self._now_s()
            await asyncio.sleep(0)
            self._step_s = max(_STEP_S, _STEP_SHARE * (self._now_s() - paused_s))
            is_next = False
        taken = None if self._closed.is_set() else await self._queue.get()
        if not is_next:
            self._step_began_s = time.thread_time()
        if taken is None:
            raise ConnectionError("the connection is closed")
        data, self._stray = taken
        if self._queue.empty():
            self._hub.resume(self)
        return data

    async def send(self, data: bytes) -> None:
        """Send to the selected address; raises `ConnectionError` once closed.

        The datagram is lost while no address is selected, such as after another peer has claimed
        it.
        """
        if self._closed.is_set():
            raise ConnectionError("the connection is closed")
        if self._agent.selected is not None:
            self._hub.send(self._agent.selected, data)

    def send_together(self, datagrams: memoryview, sizes: Sequence[int]) -> None:
        """Send datagrams stored back to back, each as `send` does."""
        if self._closed.is_set():
            raise ConnectionError("the connection is closed")
        if self._agent.selected is not None:
            self._may_segment = self._hub.send_together(
                self._agent.selected, datagrams, sizes, segmented=self._may_segment
            )

    def authenticated(self) -> None:
        """Note that the datagram that `recv` returned last was authenticated, and is no replay."""
        if self._stray is not None and not self._closed.is_set():
            self._send(self._agent.note_authenticated(self._stray, self._now_s()))
            self._report_dropped()
            self._note_path()
            self._schedule(_TICK_S)

    # --- the hub's (HubPeer) -----------------------------------------------------------------

    def handle_stun(self, message: Message, path: Path) -> None:
        now_s = self._now_s()
        self._send(self._agent.handle_request(message, path, now_s))
        if self._agent.handle_response(message, path, now_s):
            self._hub.forget(message.transaction_id)
            self._hub.claim(path, self)
        self._report_dropped()
        self._note_path()
        if self._agent.is_asking:
            self._schedule(_TICK_S)

    def handle_datagram(self, data: bytes, path: Path) -> None:
        # An empty datagram would end the peer: aiortc reads its first byte.
        if data and self._agent.note_datagram(path, self._now_s()):
            if self._queue.full():
                self._queue.get_nowait()
            self._note_path()
            self._queue.put_nowait((data, None if path == self._agent.selected else path))

    def try_stray(self, data: bytes, path: Path) -> None:
        if self._queue.empty():
            self._queue.put_nowait((data, path))

    @property
    def is_quiet(self) -> bool:
        return self._agent.is_quiet(self._now_s())

    @property
    def has_room(self) -> bool:
        return self._queue.qsize() < _ENOUGH

    def lose_path(self, path: Path) -> None:
        self._agent.refuse(path)

    # -----------------------------------------------------------------------------------------

    def _send(self, datagrams: list[Datagram]) -> None:
        for one in datagrams:
            if one.asks is not None:
                self._hub.expect(one.asks, self)
            self._hub.send(one.path, one.data)

    def _note_path(self) -> None:
        path = self._agent.selected
        if path is None:
            return
        self._decided.set()
        before, self._reached = self._reached, path
        if before not in (None, path):
            self._on_moved()

    def _report_dropped(self) -> None:
        """Tell the hub which paths and checks the agent has dropped."""
        for path, transaction in self._agent.take_dropped():
            self._hub.give_up(path, self)
            if transaction is not None:
                self._hub.forget(transaction)

    def _tick(self) -> None:
        self._timer = None
        now_s = self._now_s()
        self._send(self._agent.tick(now_s))
        self._report_dropped()
        if self._agent.is_lost(now_s):
            self._end()
        self._schedule(_TICK_S if self._agent.is_asking else _SLOW_TICK_S)

    def _schedule(self, delay_s: float) -> None:
        """Tick after this delay, or earlier if that is scheduled already."""
        if self._closed.is_set():
            return
        loop = asyncio.get_running_loop()
        if self._timer is not None:
            if self._timer.when() <= loop.time() + delay_s:
                return
            self._timer.cancel()
        self._timer = loop.call_later(delay_s, self._tick)

    def _end(self) -> None:
        if self._closed.is_set():
            return
        self._closed.set()
        self._decided.set()
        self._hub.remove(self._agent.username, self)
        if self._timer is not None:
            self._timer.cancel()
        while not self._queue.empty():
            self._queue.get_nowait()
        self._queue.put_nowait(None)
        self._local.clear()
