"""A page behind a slow uplink that lies about it: it dates its commands by their arrival."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any

from e2e.stop.operator import RawOperator

if TYPE_CHECKING:
    from e2e.harness.server import Server

_DATED: dict[str, tuple[int, ...]] = {"drive": (3, 8), "ping": (2, 4)}
"""Columns of a row that are times of its sender, and how long a pong was held."""


class LateLiar(RawOperator):
    """Everything that it sends on the drive channel is `late_s` under way, and says otherwise.

    What has been sent arrives even after the finger is off, or the page gone.
    """

    def __init__(self, server: Server, *, late_s: float, lies: bool = True) -> None:
        super().__init__(server, sees=True)
        self.late_s = late_s
        self._lies = lies
        self._honest_send = self.drive.send
        self.drive.send = self._send  # type: ignore[method-assign]

    def _send(self, data: bytes | str) -> None:
        row: list[Any] = json.loads(data)
        if self._lies:
            for column in _DATED.get(row[0], ()):
                if row[column] is not None:
                    row[column] += self.late_s * 1000
        asyncio.get_running_loop().call_later(self.late_s, self._arrive, json.dumps(row))

    def _arrive(self, row: str) -> None:
        if self.drive.readyState == "open":
            self._honest_send(row)
