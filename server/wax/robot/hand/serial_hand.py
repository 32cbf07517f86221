"""A hand control on a serial line of its own, which wakes the loop that waits for it."""

from __future__ import annotations

import contextlib
import math
import os
import threading
from collections import deque
from typing import TYPE_CHECKING, Final

import structlog

from wax.config.serial import SerialSettings
from wax.robot.hand.line import HandDecoder
from wax.robot.line.kept_line import KeptLine
from wax.robot.serial.port_line import CLOSE_TIMEOUT_S, PortLine

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.local import LocalSettings
    from wax.driver.hand import HandReading
    from wax.sentence import Sentence

_LOG = structlog.get_logger(__name__)

_MOST: Final = 4096
"""Queue limit: more readings than 115 200 baud bring before the driver process counts as hung."""
_REOPEN_S: Final = 0.2


class SerialHand:
    """A `HandSource` for any URL that pyserial opens; `wax.robot.hand.line` has the frames."""

    def __init__(self, local: LocalSettings, clock: Clock) -> None:
        self._url = local.url
        settings = SerialSettings(url=local.url, baud=local.baud, reopen_s=_REOPEN_S)
        line = PortLine(settings, clock, self, key="local.url")
        self._port = KeptLine(
            "hand", line, self, clock, reopen_s=_REOPEN_S, close_s=CLOSE_TIMEOUT_S
        )
        self._lock = threading.Lock()
        self._readings: deque[HandReading] = deque(maxlen=_MOST)
        self._decoder = HandDecoder()
        self._is_lost = False
        self._pipe: tuple[int, int] | None = None

    @property
    def wakes(self) -> int | None:
        return None if self._pipe is None else self._pipe[0]

    def open(self) -> None:
        """Start opening the line; no effect if already open."""
        if self._pipe is None:
            self._pipe = os.pipe()
            for end in self._pipe:
                os.set_blocking(end, False)
            self._port.open()

    def take(self) -> tuple[HandReading, ...] | None:
        if self._pipe is not None:
            with contextlib.suppress(BlockingIOError):
                os.read(self._pipe[0], _MOST)
        with self._lock:
            readings = tuple(self._readings)
            self._readings.clear()
            if readings:  # readings from before the loss still count: one may be a Stop
                return readings
            is_lost, self._is_lost = self._is_lost, False
        return None if is_lost else ()

    def close(self) -> None:
        self._port.close()
        with self._lock:
            pipe, self._pipe = self._pipe, None
            for end in pipe or ():
                os.close(end)

    # --- the line's threads (`PortConversation`) --------------------------------------------------

    def hello(self, now_s: float) -> bytes:  # noqa: ARG002 - of the protocol
        self._decoder = HandDecoder()
        _LOG.info("the hand control's line is open", url=self._url)
        return b""

    def next(self, now_s: float) -> tuple[bytes, float]:  # noqa: ARG002 - of the protocol
        """Write nothing: the control only sends."""
        return b"", math.inf

    def received(self, data: bytes, now_s: float) -> None:
        readings = self._decoder.feed(data, now_s)
        if readings:
            with self._lock:
                self._readings.extend(readings)
            self._wake()

    def farewell(self) -> bytes:
        return b""

    def lost(self, problem: Sentence | None) -> None:
        if problem is None:
            return  # it was closed
        _LOG.warning("the hand control's line is lost", url=self._url, problem=str(problem))
        with self._lock:
            self._is_lost = True
        self._wake()

    def _wake(self) -> None:
        with self._lock:
            pipe = self._pipe  # still open if it is there: `close` needs the lock, too
            if pipe is not None:
                with contextlib.suppress(BlockingIOError):  # the loop is already awake
                    os.write(pipe[1], b"\0")
