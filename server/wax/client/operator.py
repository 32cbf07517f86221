"""A client that drives as the page does, and can also do what no page would."""

from __future__ import annotations

import asyncio
import json
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from wax.client.client import Client

if TYPE_CHECKING:
    from wax.protocol.messages import Speed

PERIOD_S: Final = 0.02


@dataclass(frozen=True, slots=True)
class Sent:
    """One command sent; `at_s` is this process's `time.monotonic` in seconds."""

    seq: int
    at_s: float


class Operator(Client):
    """Sends the state of its controls 50 times a second while it has the turn.

    With `sees` its commands claim the newest possible picture, otherwise `seen_server_ms`. With
    `persists` it keeps sending commands after its turn, under that turn's number. While `is_silent`
    it sends no commands, but stays connected.
    """

    is_keen = True

    def __init__(
        self,
        url: str,
        *,
        sees: bool = False,
        speed: Speed = "fast",
        persists: bool = False,
        **options: Any,
    ) -> None:
        super().__init__(url, sound=False, picture=sees, **options)
        self.linear = self.angular = self.lateral = 0.0
        self.held = False
        self.speed: Speed = speed
        self.sees_now = sees
        self.seen_server_ms: float | None = None
        self.is_silent = False
        self.sent_before: list[Sent] = []
        """Every command since the start, or since the list was cleared."""
        self.worst_late_s = 0.0
        """The longest delay of its own timer, which is not the server's fault."""
        self._persists = persists
        self._own_turn = 0
        self._seq = 0

    async def connect(self) -> None:
        await super().connect()
        self._start(self._command_always(), "commands")

    # --- the turn -----------------------------------------------------------------------------

    @property
    def viewer(self) -> int | None:
        """Its number among the viewers, None before the server's hello."""
        number: int | None = self.newest("hello").get("viewer")
        return number

    @property
    def turn(self) -> int:
        """The number of the current turn, whoever has it."""
        return int(self.newest("room").get("turn", {}).get("number", 0))

    @property
    def has_turn(self) -> bool:
        operator = self.newest("room").get("turn", {}).get("operator")
        return operator is not None and operator == self.viewer

    @property
    def ends_server_ms(self) -> float | None:
        """When the current turn ends, on the server's clock."""
        ends_ms: float | None = self.newest("room").get("turn", {}).get("ends_server_ms")
        return ends_ms

    @property
    def stopped(self) -> int | None:
        """The number of the latched stop, None if none is."""
        stop = self.newest("room").get("stop")
        return None if stop is None else int(stop["number"])

    async def join(self) -> None:
        """Ask for a turn and wait for it; raises `TimeoutError`."""
        self.send(type="join")
        await self.gets_turn()

    async def leave(self) -> None:
        """Leave the turn and wait for its end; raises `TimeoutError`."""
        self.send(type="leave")
        if not await self.until(lambda: not self.has_turn):
            raise TimeoutError("the turn does not end")

    async def gets_turn(self, within_s: float = 15.0) -> None:
        """Wait for the turn; raises `TimeoutError`."""
        if not await self.until(lambda: self.has_turn, within_s):
            raise TimeoutError(f"no turn within {within_s:g} s")

    # --- controls -----------------------------------------------------------------------------

    def steer(self, linear: float, angular: float = 0.0, lateral: float = 0.0) -> None:
        """Hold a control down from now on; shares of the robot's limits in -1…1."""
        self.linear, self.angular, self.lateral, self.held = linear, angular, lateral, True

    def let_go(self) -> None:
        """Release the control: send it at once, and keep sending it."""
        self.linear = self.angular = self.lateral = 0.0
        self.held = False
        if self._commands():
            self.command()

    def command(self) -> None:
        """Send the state of the controls now, outside the timer."""
        self.drive.send(self.row(self.next_seq()))
        self.sent_before.append(Sent(self._seq, time.monotonic()))

    def row(self, seq: int, **other: Any) -> str:
        """Write a command; `other` replaces any of its fields."""
        if self.has_turn:
            self._own_turn = self.turn
        said: dict[str, Any] = {
            "turn": self._own_turn,
            "sent_server_ms": self.server_ms(),
            "linear": self.linear,
            "angular": self.angular,
            "held": self.held,
            "speed": self.speed,
            "seen_server_ms": self.server_ms() if self.sees_now else self.seen_server_ms,
            "axes": {},
            "beat": self.beat,
            **({"lateral": self.lateral} if self.lateral else {}),
        } | other
        return json.dumps(["drive", seq, *said.values()], separators=(",", ":"))

    def next_seq(self) -> int:
        """Return a sequence number that no other command will have."""
        self._seq += 1
        return self._seq

    # --- the stop -----------------------------------------------------------------------------

    async def press_stop(self) -> int:
        """Stop by HTTP; returns the stop's number."""
        return int((await self.post("/api/stop", {}))["stop"])

    def release(self, stop: int) -> None:
        """Release this stop on the state channel."""
        self.send(type="release", stop=stop, sent_server_ms=self.server_ms(), beat=self.beat)

    # --- inside -------------------------------------------------------------------------------

    def _commands(self) -> bool:
        may = self.has_turn or (self._persists and self._own_turn > 0)
        return may and not self.is_silent and self.drive.readyState == "open"

    async def _command_always(self) -> None:
        """Send commands on time; skipped ones are not made up for after a long delay."""
        due_s = time.monotonic()
        while self.drive.readyState == "open":
            if self._commands():
                self.command()
            due_s += PERIOD_S
            await asyncio.sleep(max(0.0, due_s - time.monotonic()))
            late_s = time.monotonic() - due_s
            self.worst_late_s = max(self.worst_late_s, late_s)
            if late_s > PERIOD_S:
                due_s += late_s
