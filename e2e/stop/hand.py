"""The hand control of a person aboard: a pseudo-terminal that speaks as a real one does.

It speaks 50 times a second, and at once when it is touched.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import time
import tty
from typing import Any, Final, Self

from wax.driver.hand import HandReading
from wax.robot.hand.line import encode

PAUSE_S: Final = 0.5
_PERIOD_S: Final = 0.02


class HandControl:
    """A rig of `Fault`; enter it in the event loop."""

    def __init__(self) -> None:
        self._end, self._port = os.openpty()
        tty.setraw(self._port)
        os.set_blocking(self._end, False)
        local = {"source": "serial", "url": os.ttyname(self._port), "pause_s": PAUSE_S}
        self.settings: dict[str, Any] = {"local": local}
        self.environment: dict[str, str] = {}
        self._is_held = False
        self._number = 0

    def __enter__(self) -> Self:
        self._speaking = asyncio.create_task(self._speak())
        return self

    def __exit__(self, *_: object) -> None:
        self._speaking.cancel()
        for descriptor in (self._end, self._port):
            os.close(descriptor)

    def touch(self) -> float:
        """Let the person lay their hand on it; return when."""
        now_s = time.monotonic()
        self._is_held = True
        self._say()
        return now_s

    def let_go(self) -> None:
        self._is_held = False
        self._say()

    async def _speak(self) -> None:
        while True:
            self._say()
            await asyncio.sleep(_PERIOD_S)

    def _say(self) -> None:
        self._number += 1
        with contextlib.suppress(BlockingIOError):  # nobody reads it yet
            os.write(self._end, encode(HandReading(0.0, is_held=self._is_held), self._number))
