"""Keep a serial port open: open it, report why it failed, open it again.

Opening raises DTR, at which many boards restart and listen only after a second or two; until then
the robot stands, and repeated frames reach it once it listens.
"""

from __future__ import annotations

import errno
import threading
from typing import TYPE_CHECKING, Final, Protocol

import serial

from wax.errors import DriverError
from wax.robot.serial.port_threads import Conversation, PortThreads

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.settings import SerialSettings

READ_TIMEOUT_S: Final = 0.1
WRITE_TIMEOUT_S: Final = 0.25
CLOSE_TIMEOUT_S: Final = 0.9


class Caller(Conversation, Protocol):
    """A conversation that is notified when the port is lost."""

    def lost(self, problem: DriverError) -> None:
        """Handle the loss of the port."""
        ...


class Port:
    """One serial port, kept open from `open` to `close` whatever happens to it.

    `part` is what is plugged in there, and `key` the configuration's name of its port, for people.
    """

    def __init__(
        self,
        settings: SerialSettings,
        clock: Clock,
        caller: Caller,
        *,
        part: str = "robot",
        key: str = "robot.serial.url",
    ) -> None:
        self._settings = settings
        self._part = part
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
        """Open the port and run the conversation until it ends; return why it was lost."""
        try:
            port = self._open_port()
        except Exception as error:
            # The handlers of pyserial's URLs raise all sorts of exceptions.
            return DriverError(why_not_open(self._settings.url, error, self._part, self._key))
        if closing.is_set():
            port.close()
            return None
        line = self._line = PortThreads(port, self._clock, self._caller)
        if closing.is_set():
            line.close()
        try:
            line.run()
        except Exception as error:
            return DriverError(_why_lost(self._settings, error, self._part))
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


def _why_lost(settings: SerialSettings, error: Exception, part: str) -> str:
    return (
        f"The {part}'s serial port {settings.url} was lost ({error}): check the cable and the "
        f"{part}'s power. Retrying every {settings.reopen_s:g} s."
    )


def why_not_open(
    url: str, error: Exception, part: str = "robot", key: str = "robot.serial.url"
) -> str:
    """Return a sentence that says why a port did not open and what to do."""
    number = getattr(error, "errno", None)
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
        return (
            f"There is no serial port {url}: plug the {part} in, or set {key} to one "
            "listed by `wax devices`."
        )
    if number in (errno.EACCES, errno.EPERM):
        return (
            f"You may not open the serial port {url}: add yourself to its group, on Debian and "
            "Ubuntu with `sudo usermod -aG dialout $USER`, and log in again."
        )
    if number in (errno.EAGAIN, errno.EBUSY):
        return f"Another program is using the serial port {url}: end it first."
    return f"The serial port {url} cannot be opened: {error}."
