"""The robot's end of a serial line: a pseudo-terminal that notes when each piece arrived.

It is read in a process of its own, because a busy thread next door would make bytes look late.
"""

from __future__ import annotations

import multiprocessing
import os
import select
import time
import tty
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from e2e.bench.errors import BenchError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from types import TracebackType

START_TIMEOUT_S = 10.0


@dataclass(frozen=True, slots=True)
class Piece:
    """Bytes read at once, on CLOCK_MONOTONIC."""

    at_ms: float
    data: bytes


class SerialLine:
    """`with SerialLine() as line:` — `line.url` is for the server, `line.finish()` tells all."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._end, far_end = context.Pipe()
        self._process = context.Process(target=_main, args=(far_end,), daemon=True)
        self._process.start()
        far_end.close()
        self.url = str(self._receive())

    def __enter__(self) -> SerialLine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end.close()
        self._process.kill()
        self._process.join()

    def finish(self) -> list[Piece]:
        """Everything that arrived, oldest first; once."""
        self._end.send(None)
        pieces = self._receive()
        if not isinstance(pieces, list):
            raise BenchError("the serial line's process gave no bytes")
        return pieces

    def _receive(self) -> object:
        try:
            if self._end.poll(START_TIMEOUT_S):
                return self._end.recv()
        except (OSError, EOFError) as error:
            raise BenchError("the serial line's process has ended") from error
        raise BenchError("the serial line's process does not answer")


def _main(end: Connection[Any, Any]) -> None:
    robot, server = os.openpty()
    try:
        tty.setraw(server)
        end.send(os.ttyname(server))
        pieces: list[Piece] = []
        while True:
            ready, _, _ = select.select([robot, end.fileno()], [], [])
            now_ms = time.monotonic() * 1000
            if robot in ready:
                pieces.append(Piece(at_ms=now_ms, data=os.read(robot, 4096)))
            if end.fileno() in ready:
                end.recv()
                end.send(pieces)
                return
    except (EOFError, KeyboardInterrupt):
        pass  # the benchmark has ended
    finally:
        os.close(robot)
        os.close(server)
