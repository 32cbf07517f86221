"""An operator in a process of its own, which obeys orders and reports the server's state.

`python -m wax.client.process URL CLIENT_ID COOKIES` can be frozen whole, like a vanished network:
no command, heartbeat or acknowledgement leaves it. It can be killed, like a crashed browser: the
file COOKIES makes its successor the same person. Each line on its standard input is an order; each
line on its standard output is a new `OperatorState` in JSON. It ends with its input, or when it
loses the server.
"""

from __future__ import annotations

import asyncio
import json
import sys
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import aiohttp
from pydantic import TypeAdapter

from wax.client.operator import Operator
from wax.sentence import read

if TYPE_CHECKING:
    from collections.abc import Coroutine

Order = Literal[
    "join",
    "leave",
    "neutral",
    "drive",
    "reverse",
    "sideways",
    "stop",
    "stop by http",
    "release",
    "reconnect",
]
ORDERS: TypeAdapter[Order] = TypeAdapter(Order)
_WAYS: Final = {"drive": (1.0, 0.0, 0.0), "reverse": (-1.0, 0.0, 0.0), "sideways": (0.0, 0.0, 1.0)}
"""The speed of each way that it drives: ahead, turning, to the left."""


@dataclass(frozen=True, slots=True)
class OperatorState:
    """The server's state for this operator: its turn, the latched stop, and any obstacle.

    `ends_ms` is when the turn ends, in ms of this machine's `time.monotonic`.
    """

    is_open: bool = False
    drives: bool = False
    turn: int = 0
    ends_ms: float | None = None
    stop: int | None = None
    reason: str | None = None


class OrderedOperator:
    """Obeys orders; keeps driving through every stop and after its turn, as no page would."""

    def __init__(self, url: str, client_id: str, kept: Path) -> None:
        self._url = url
        self._client_id = client_id
        self._kept = kept
        self._cookies = aiohttp.CookieJar(unsafe=True)
        if kept.exists():
            self._cookies.load(kept)
        self._state = OperatorState()
        self._works: set[asyncio.Task[Any]] = set()
        self._operator = self._new()

    async def run(self) -> None:
        """Drive until the server is lost."""
        await self._operator.connect()
        self._cookies.save(self._kept)
        self._tell()
        while self._operator.is_open:
            await self._operator.until(partial(_is_closed, self._operator), None)
            # The server closes a connection whose page reconnects: the next one takes its place.
            await asyncio.gather(*self._works, return_exceptions=True)

    async def close(self) -> None:
        await asyncio.gather(*self._works, return_exceptions=True)
        await self._operator.close()

    def obey(self, order: Order) -> None:
        """Carry out an order; like a page, it sends nothing on a closed channel."""
        operator = self._operator
        match order:
            case "join" | "leave" | "stop":
                if operator.is_open:
                    operator.send(type=order)
            case "neutral":
                operator.let_go()
            case "drive" | "reverse" | "sideways":
                operator.steer(*_WAYS[order])
            case "stop by http":
                self._begin(operator.press_stop())
            case "release":
                if operator.is_open and operator.stopped is not None:
                    operator.release(operator.stopped)
            case "reconnect":
                self._begin(self._reconnect())

    async def _reconnect(self) -> None:
        """Reconnect as a reloaded page, with its controls unchanged."""
        old, new = self._operator, self._new()
        await new.connect()
        new.linear, new.angular, new.lateral = old.linear, old.angular, old.lateral
        new.held = old.held
        self._operator = new
        self._tell()
        await old.close()

    def _new(self) -> Operator:
        return Operator(
            self._url,
            client_id=self._client_id,
            cookies=self._cookies,
            name="Proof of the stop",
            speed="slow",
            persists=True,
            on_message=lambda _: self._tell(),
        )

    def _begin(self, work: Coroutine[Any, Any, Any]) -> None:
        task = asyncio.create_task(work)
        self._works.add(task)
        task.add_done_callback(self._works.discard)

    def _tell(self) -> None:
        operator = self._operator
        ends_server_ms = operator.ends_server_ms
        state = OperatorState(
            is_open=operator.is_open,
            drives=operator.has_turn,
            turn=operator.turn,
            ends_ms=None if ends_server_ms is None else ends_server_ms - operator.clock.ahead_ms,
            stop=operator.stopped,
            reason=_words(operator.newest("drive_status").get("reason")),
        )
        if state != self._state:
            self._state = state
            sys.stdout.write(json.dumps(asdict(state)) + "\n")
            sys.stdout.flush()


def _words(sentence: object) -> str | None:
    return None if sentence is None else str(read(sentence))


def _is_closed(operator: Operator) -> bool:
    return not operator.is_open


async def _obey(operator: OrderedOperator, orders: asyncio.StreamReader) -> None:
    async for line in orders:
        operator.obey(ORDERS.validate_python(line.decode().strip()))


async def _first(*works: Coroutine[Any, Any, None]) -> None:
    """Run all until the first one ends: the link is lost, or the orders end."""
    tasks = [asyncio.create_task(work) for work in works]
    done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        task.result()


async def _main(url: str, client_id: str, kept: Path) -> None:
    loop = asyncio.get_running_loop()
    orders = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(orders), sys.stdin)
    operator = OrderedOperator(url, client_id, kept)
    try:
        await _first(operator.run(), _obey(operator, orders))
    finally:
        await operator.close()


if __name__ == "__main__":
    asyncio.run(_main(sys.argv[1], sys.argv[2], Path(sys.argv[3])))
