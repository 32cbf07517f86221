"""Keeps a serial port open: it reports why the port failed and reopens it after `reopen_s`.

Opening a port raises DTR, which restarts many boards: they listen only after a second or two. Until
then the robot stands still, and repeated frames reach it later. `list_ports` finds lasting names.
"""

from __future__ import annotations

import errno
import threading
from typing import TYPE_CHECKING, Final, Protocol

import serial

from wax.errors import DriverError
from wax.robot.serial.port_threads import PortConversation, PortThreads
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.serial import SerialSettings

READ_TIMEOUT_S: Final = 0.1
WRITE_TIMEOUT_S: Final = 0.25
CLOSE_TIMEOUT_S: Final = 0.9


class Caller(PortConversation, Protocol):
    """A conversation that is notified when the port is lost."""

    def lost(self, problem: DriverError) -> None:
        """Handle the loss of the port."""
        ...


class Port:
    """One serial port, kept open from `open` to `close` whatever happens to it.

    `key` is its key in the configuration, for messages.
    """

    def __init__(
        self,
        settings: SerialSettings,
        clock: Clock,
        caller: Caller,
        *,
        key: str = "robot.serial.url",
    ) -> None:
        self._settings = settings
        self._key = key
        self._clock = clock
        self._caller = caller
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._line: PortThreads | None = None

    def open(self) -> None:
        """Start opening the port and keep trying; no effect if already started."""
        if self._thread is not None:
            return
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=self._keep, args=(self._closing,), name="serial port", daemon=True
        )
        self._thread.start()

    def wake(self) -> None:
        """Call the conversation's `next` now."""
        line = self._line
        if line is not None:
            line.wake()

    def close(self) -> None:
        """Write the farewell and close the port; takes at most a second, safe to call twice."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._closing.set()
        line = self._line
        if line is not None:
            line.close()
        thread.join(CLOSE_TIMEOUT_S)

    def _keep(self, closing: threading.Event) -> None:
        while not closing.is_set():
            problem = self._use(closing)
            if problem is not None and not closing.is_set():
                self._caller.lost(problem)
                closing.wait(self._settings.reopen_s)

    def _use(self, closing: threading.Event) -> DriverError | None:
        """Open the port and run the conversation until the port fails; return why."""
        try:
            port = self._open_port()
        except Exception as error:
            # pyserial's URL handlers raise all sorts of exceptions.
            return DriverError(why_not_open(self._settings.url, error, self._key))
        if closing.is_set():
            port.close()
            return None
        line = self._line = PortThreads(port, self._clock, self._caller)
        if closing.is_set():
            line.close()
        try:
            line.run()
        except Exception as error:
            return DriverError(_why_lost(self._settings, error))
        finally:
            self._line = None
        return None

    def _open_port(self) -> serial.Serial:
        return serial.serial_for_url(
            self._settings.url,
            baudrate=self._settings.baud,
            timeout=READ_TIMEOUT_S,
            write_timeout=WRITE_TIMEOUT_S,
            exclusive=True,
        )


def _why_lost(settings: SerialSettings, error: Exception) -> Sentence:
    return Sentence(
        "port.lost", {"port": settings.url, "why": str(error), "seconds": settings.reopen_s}
    )


def why_not_open(url: str, error: Exception, key: str = "robot.serial.url") -> Sentence:
    """Return a sentence that says why a port did not open and what to do."""
    number = getattr(error, "errno", None)
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
        return Sentence("port.missing", {"port": url, "key": key})
    if number in (errno.EACCES, errno.EPERM):
        return Sentence("port.forbidden", {"port": url})
    if number in (errno.EAGAIN, errno.EBUSY):
        return Sentence("port.busy", {"port": url})
    return Sentence("port.not_open", {"port": url, "why": str(error)})
