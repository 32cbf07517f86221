"""One open serial port: one thread writes as soon as there is data, another reads."""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, Final, Protocol

import serial

if TYPE_CHECKING:
    from wax.clock import Clock

MAX_READ_BYTES: Final = 4096


class PortConversation(Protocol):
    """Provides the bytes for a port and handles those from it. The port's threads call it."""

    def opened(self, now_s: float) -> bytes:
        """Handle that the port is open; return the first bytes to write."""
        ...

    def next(self, now_s: float) -> tuple[bytes, float]:
        """Return the bytes to write now, and the latest time of the next call."""
        ...

    def received(self, data: bytes, now_s: float) -> None:
        """Handle data from the robot."""
        ...

    def farewell(self) -> bytes:
        """Return the last bytes to write."""
        ...


class PortThreads:
    """Carries a conversation over `port`, which must have short timeouts, and closes it."""

    def __init__(self, port: serial.Serial, clock: Clock, conversation: PortConversation) -> None:
        self._port = port
        self._clock = clock
        self._conversation = conversation
        self._changed = threading.Condition()
        self._news = False
        self._closing = False
        self._ended = False
        self._error: Exception | None = None

    def wake(self) -> None:
        """Call the conversation's `next` now."""
        with self._changed:
            self._news = True
            self._changed.notify()

    def close(self) -> None:
        """Make `run` write the farewell and return."""
        with self._changed:
            self._closing = True
            self._changed.notify()

    def run(self) -> None:
        """Read and write until `close`; raises whatever the port raises when it is lost.

        The farewell is also tried on a failed port: a board without a watchdog would otherwise
        follow its last command until the port is reopened.
        """
        reader = threading.Thread(target=self._read, name="serial reader", daemon=True)
        try:
            self._port.write(self._conversation.opened(self._clock.now_s()))
            reader.start()
            self._write()
        except Exception as error:
            self._last_words(error)
            raise
        finally:
            self._ended = True
            if reader.ident is not None:
                reader.join()
            self._port.close()

    def _write(self) -> None:
        while True:
            with self._changed:
                self._news = False
            words, due_s = self._conversation.next(self._clock.now_s())
            if words:
                self._port.write(words)
            with self._changed:
                pause_s = min(max(0.0, due_s - self._clock.now_s()), threading.TIMEOUT_MAX)
                self._changed.wait_for(self._must_act, pause_s)
                if self._error is not None:
                    raise self._error
                if self._closing:
                    break
        self._port.write(self._conversation.farewell())
        self._port.flush()

    def _last_words(self, error: Exception) -> None:
        """Write the farewell to a port that has just failed; takes no longer than its timeout."""
        with contextlib.suppress(Exception):  # it may fail again
            if isinstance(error, serial.SerialTimeoutException):
                self._port.reset_output_buffer()  # full of stale frames
            self._port.write(self._conversation.farewell())

    def _must_act(self) -> bool:
        return self._news or self._closing or self._error is not None

    def _read(self) -> None:
        try:
            while not self._ended:
                data = self._port.read(max(1, min(self._port.in_waiting, MAX_READ_BYTES)))
                if data:
                    self._conversation.received(data, self._clock.now_s())
        except Exception as error:
            # The writer will fail with the same error and report it.
            with self._changed:
                self._error = error
                self._changed.notify()
