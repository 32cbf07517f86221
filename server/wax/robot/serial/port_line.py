"""A serial port as a line.

Opening a port raises DTR, which restarts many boards: they listen only after a second or two. Until
then the robot stands still, and repeated frames reach it later. `list_ports` finds lasting names.
"""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING, ClassVar, Final, Protocol

import serial

from wax.robot.line.kept_line import LineUser, RobotLine
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.config.serial import SerialSettings

READ_TIMEOUT_S: Final = 0.1
WRITE_TIMEOUT_S: Final = 0.25
CLOSE_TIMEOUT_S: Final = 0.9
MAX_READ_BYTES: Final = 4096


class PortConversation(LineUser, Protocol):
    """Provides the bytes for a port and handles those from it. The port's threads call it."""

    def hello(self, now_s: float) -> bytes:
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


class PortLine(RobotLine):
    """Carries a conversation over any URL that pyserial opens.

    `key` is its key in the configuration, for messages.
    """

    hears: ClassVar[bool] = True
    _port: serial.Serial

    def __init__(
        self,
        settings: SerialSettings,
        clock: Clock,
        conversation: PortConversation,
        *,
        key: str = "robot.serial.url",
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._conversation = conversation
        self._key = key

    def open(self, wake: Callable[[], None]) -> None:  # noqa: ARG002 - of the base class
        self._port = serial.serial_for_url(
            self._settings.url,
            baudrate=self._settings.baud,
            timeout=READ_TIMEOUT_S,
            write_timeout=WRITE_TIMEOUT_S,
            exclusive=True,
        )

    def begin(self, now_s: float) -> None:
        self._port.write(self._conversation.hello(now_s))

    def step(self, now_s: float) -> float:
        words, due_s = self._conversation.next(now_s)
        if words:
            self._port.write(words)
        return due_s

    def hear(self) -> bool:
        data = self._port.read(max(1, min(self._port.in_waiting, MAX_READ_BYTES)))
        if data:
            self._conversation.received(data, self._clock.now_s())
        return False

    def leave(self, now_s: float) -> float:  # noqa: ARG002 - it is said at once
        self._port.write(self._conversation.farewell())
        self._port.flush()
        return 0.0

    def last_words(self, error: Exception) -> None:
        """Write the farewell to a port that has just failed; takes no longer than its timeout.

        A board without a watchdog would otherwise follow its last command until the port is
        reopened.
        """
        if isinstance(error, serial.SerialTimeoutException):
            self._port.reset_output_buffer()  # full of stale frames
        self._port.write(self._conversation.farewell())

    def close(self) -> None:
        self._port.close()
        del self._port  # pyserial leaves a socket that was reset to the garbage collector

    def problem(self, error: Exception, *, was_open: bool) -> Sentence:
        url, seconds = self._settings.url, self._settings.reopen_s
        if was_open:
            return Sentence("port.lost", {"port": url, "why": str(error), "seconds": seconds})
        # pyserial's URL handlers raise all sorts of exceptions.
        return why_not_open(url, error, self._key)


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
