"""A raw peer with hands: it drives as the page does, and can do what no page would."""

from __future__ import annotations

import asyncio
import json
import time
import uuid
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self

import aiohttp

from e2e.faults.relay import without_candidates
from e2e.harness.raw_peer import RawPeer
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from types import TracebackType

    from e2e.faults.relay import Relay
    from e2e.harness.server import Server

PERIOD_S: Final = 0.02
_CLOCKS: Final = 32
_ELSEWHERE: Final = {"X-Forwarded-For": "192.0.2.1"}
"""Only whoever is not on the server's machine is refused a release (documentation address)."""


@dataclass(frozen=True, slots=True)
class Sent:
    """One command, by this peer's own clock."""

    seq: int
    at_s: float


class RawOperator(RawPeer):
    """Use as an async context manager; `steer`, and it sends 50 commands a second while it has
    the turn. `relay` is its network; with None it has the loopback.
    """

    def __init__(
        self,
        server: Server,
        *,
        client: str | None = None,
        relay: Relay | None = None,
        is_host: bool = False,
        sees: bool = False,
    ) -> None:
        super().__init__(server)
        self.client = client or str(uuid.uuid4())
        self.number = -1
        self.turn = -1
        self.has_turn = False
        self.ends_server_ms: float | None = None
        self.told = asyncio.Event()
        """Set at each message about the room."""
        self.linear = self.angular = 0.0
        self.held = False
        self.speed = "gross"
        self.seen_server_ms: float | None = None
        self.sees_now = sees
        """Commands say that the picture is as new as can be; else `seen_server_ms`."""
        self.is_silent = False
        self.sent_before: list[Sent] = []
        """Every command since the start, or since somebody cleared it."""
        self.worst_late_s = 0.0
        """How late this peer's own beat was at worst: what is not the server's fault."""
        self._wants_picture = sees
        self._relay = relay
        self._headers = {} if is_host else _ELSEWHERE
        self._seq = 0
        self._driving: asyncio.Task[None] | None = None
        self._pinged: dict[int, float] = {}
        self._pong: tuple[int, float] | None = None
        self._clocks: list[tuple[float, float]] = []
        self.state.on("message", self._take_state)

    async def __aenter__(self) -> Self:
        await super().__aenter__()
        await eventually(self._is_greeted, "the server greets", every_s=0.01)
        self.say(
            type="want",
            sound=False,
            picture=self._wants_picture,
            size=self.newest("hello")["sizes"][0],
            policy=None,
        )
        self._driving = asyncio.create_task(self._drive(), name="drive")
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._driving is not None:
            self._driving.cancel()
            with suppress(asyncio.CancelledError):
                await self._driving
        try:
            await super().__aexit__(kind, error, trace)
        finally:
            if self._relay is not None:
                self._relay.close()

    @property
    def one_way_s(self) -> float:
        """Half the least of the latest round trips."""
        return min(self._clocks)[0] / 2000

    # --- hands ---------------------------------------------------------------------------------

    def steer(self, linear: float, angular: float = 0.0) -> None:
        """Hold a control down from now on."""
        self.linear, self.angular, self.held = linear, angular, True

    def let_go(self) -> None:
        """Say so at once, and go on saying it."""
        self.linear = self.angular = 0.0
        self.held = False
        if self.has_turn and not self.is_silent:
            self.command()

    def command(self) -> None:
        """Send what the hands say now, out of the beat."""
        self._seq += 1
        row = self.row(self._seq)
        self.drive.send(row)
        self.sent_before.append(Sent(self._seq, time.monotonic()))

    def row(self, seq: int, **other: Any) -> str:
        """Write a command; `other` replaces what the hands say."""
        seen = self.server_ms() if self.sees_now else self.seen_server_ms
        said: dict[str, Any] = {
            "turn": self.turn,
            "sent_server_ms": self.server_ms(),
            "linear": self.linear,
            "angular": self.angular,
            "held": self.held,
            "speed": self.speed,
            "seen_server_ms": seen,
            "axes": {},
        } | other
        return json.dumps(["drive", seq, *said.values()], separators=(",", ":"))

    def next_seq(self) -> int:
        """Take a number that no command of the beat will have."""
        self._seq += 1
        return self._seq

    # --- the reliable channel and HTTP ---------------------------------------------------------

    def say(self, **message: Any) -> None:
        """Send one message on the state channel."""
        self.state.send(json.dumps(message))

    async def join(self) -> None:
        """Ask for a turn, and wait until it has come."""
        self.say(type="join")
        await self.gets_turn()

    async def leave(self) -> None:
        """End the turn, and wait until it has ended."""
        self.say(type="leave")
        async with asyncio.timeout(5):
            while self.has_turn:
                self.told.clear()
                await self.told.wait()

    async def gets_turn(self, within_s: float = 15) -> None:
        async with asyncio.timeout(within_s):
            while not self.has_turn:
                self.told.clear()
                await self.told.wait()

    async def press_stop(self) -> int:
        """Stop by HTTP; returns the stop's number."""
        return int((await self._post("/api/stop", {}))["stop"])

    def release(self, stop: int) -> None:
        """Release by the channel."""
        self.say(type="release", stop=stop, sent_server_ms=self.server_ms())

    @property
    def stopped(self) -> int | None:
        """The number of the stop that is latched, as this peer was told."""
        stop = self.newest("room").get("stop")
        return None if stop is None else int(stop["number"])

    # --- inside --------------------------------------------------------------------------------

    async def _drive(self) -> None:
        due_s = time.monotonic()
        while True:
            if self.has_turn and not self.is_silent and self.drive.readyState == "open":
                self.command()
            due_s += PERIOD_S
            await asyncio.sleep(max(0.0, due_s - time.monotonic()))
            late_s = time.monotonic() - due_s
            self.worst_late_s = max(self.worst_late_s, late_s)
            if late_s > PERIOD_S:
                due_s += late_s

    async def _post(self, path: str, body: dict[str, Any]) -> dict[str, Any]:
        async with (
            aiohttp.ClientSession() as http,
            http.post(
                self._server.url + path,
                json={"client": self.client, **body},
                headers=self._headers,
            ) as response,
        ):
            assert response.status == 200, f"{path}: {response.status} {await response.text()}"
            answer = await response.json()
            assert isinstance(answer, dict)
            return answer

    def _take_state(self, data: str | bytes) -> None:
        message = json.loads(data)
        match message["type"]:
            case "hello":
                self.number = int(message["viewer"])
            case "room":
                turn = message["turn"]
                self.turn = int(turn["number"])
                self.has_turn = turn["operator"] == self.number
                self.ends_server_ms = turn["ends_server_ms"]
                self.told.set()

    def _ping(self) -> int:
        number = next(self._pings)
        now_ms = time.monotonic() * 1000
        pong, held_ms = None, None
        if self._pong is not None:
            pong, held_ms = self._pong[0], now_ms - self._pong[1]
        self._pinged[number] = now_ms
        self.drive.send(json.dumps(["ping", number, now_ms, pong, held_ms]))
        return number

    def _take_pong(self, data: str | bytes) -> None:
        """Align the clocks by the quickest of the latest round trips, as the page does."""
        now_ms = time.monotonic() * 1000
        _, number, _, server_ms = json.loads(data)
        sent_ms = self._pinged.pop(number, None)
        self._answered.add(number)
        if sent_ms is None:
            return
        self._pong = (number, now_ms)
        self._clocks.append((now_ms - sent_ms, server_ms - (sent_ms + now_ms) / 2))
        del self._clocks[:-_CLOCKS]
        self._ahead_ms = min(self._clocks)[1]

    async def _is_greeted(self) -> bool:
        return self.newest("hello") != {}

    async def _answer(self, offer: str) -> str:
        if self._relay is None:
            return str((await self._post("/api/offer", {"sdp": offer}))["sdp"])
        offer = without_candidates(offer)
        answer = str((await self._post("/api/offer", {"sdp": offer}))["sdp"])
        return await self._relay.answer(answer)
