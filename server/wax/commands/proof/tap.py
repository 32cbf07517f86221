"""A tap on the robot's serial line: bytes pass both ways, are recorded, and can be cut.

The server under proof opens a pseudo-terminal of ours, the tap opens the robot's port.
"""

from __future__ import annotations

import contextlib
import os
import pty
import select
import threading
import time
import tty
from typing import TYPE_CHECKING, Final, Literal

import serial

from wax.commands.proof.config_file import tapped
from wax.errors import DriverError

if TYPE_CHECKING:
    from wax.commands.proof.line_decoder import LineDecoder
    from wax.commands.proof.measure import Event
    from wax.config.serial import SerialSettings
    from wax.config.settings import Settings

_READ_S: Final = 0.05
_WRITE_S: Final = 0.25
_MAX_BYTES: Final = 4096
_LAST_WORDS: Final = 10
_LAST_WORDS_EVERY_S: Final = 0.05
_NO_WATCHDOG: Final = (
    'robots with the dialect "bytes" have no known watchdog and do not report whether they move.'
    " Expect this one to keep moving."
)


class Tap:
    """Forwards bytes from `open` to `close`, in two threads; `path` is the server's port."""

    sees: Literal["line"] = "line"

    def __init__(self, settings: SerialSettings, language: LineDecoder) -> None:
        self._settings = settings
        self._language = language
        self._lock = threading.Lock()
        self._events: list[Event] = []
        self._problem: Exception | None = None
        self._carries = True
        self._is_open = False
        self._threads: list[threading.Thread] = []

    @property
    def reports(self) -> bool:
        return self._language.reports

    @property
    def skips(self) -> dict[str, str]:
        return {} if self.reports else {"driver": _NO_WATCHDOG, "cut": _NO_WATCHDOG}

    def configuration(self, settings: Settings, folder: str) -> str:
        return tapped(settings, self.path, f"{folder}/state")

    def missing(self) -> None:
        """Return None: the traffic on a line always shows motion."""

    async def ended(self) -> None:
        """Return at once: the tap itself has stopped and released the robot."""

    def open(self) -> None:
        """Open the robot's port; raises `DriverError`."""
        try:
            self._port = serial.serial_for_url(
                self._settings.url,
                baudrate=self._settings.baud,
                timeout=_READ_S,
                write_timeout=_WRITE_S,
                exclusive=True,
            )
        except Exception as error:  # pyserial's URL handlers raise all sorts
            raise DriverError(
                f"the robot's port {self._settings.url} cannot be opened: {error}; end the"
                " program that uses it, such as a running server, or plug the robot in"
            ) from error
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.path = os.ttyname(self._theirs)
        self._is_open = True
        self._threads = [
            threading.Thread(target=self._keep, args=(way,), name=name, daemon=True)
            for way, name in ((self._carry_down, "tap to robot"), (self._carry_up, "tap to server"))
        ]
        for thread in self._threads:
            thread.start()

    def cut(self) -> None:
        """Stop forwarding in both directions; the robot's reports are still recorded."""
        with self._lock:
            self._carries = False

    def mend(self) -> None:
        with self._lock:
            self._carries = True

    def forget(self) -> None:
        """Start a new list of events."""
        with self._lock:
            self._events.clear()

    def events(self) -> list[Event]:
        """Return the events since `forget`; raises `DriverError` if the port is lost."""
        if self._problem is not None:
            raise DriverError(f"the robot's port was lost: {self._problem}; check its cable")
        with self._lock:
            return list(self._events)

    def moves(self) -> bool:
        """Whether the robot moves by its newest report, or without reports by its last command."""
        who = "told" if self._language.reports else "said"
        return next((event.moves for event in reversed(self.events()) if event.who == who), False)

    def close(self) -> None:
        """Stop the robot, then close both ends; never raises, safe to call twice."""
        if not self._is_open:
            return
        self.cut()
        for _ in range(_LAST_WORDS):  # one may be lost, or hit the middle of a frame
            with contextlib.suppress(Exception), self._lock:  # a lost port may come back
                self._write(self._language.last_words())
            time.sleep(_LAST_WORDS_EVERY_S)
        self._is_open = False
        for thread in self._threads:
            thread.join()
        self._port.close()
        os.close(self._ours)
        os.close(self._theirs)

    def _keep(self, way: object) -> None:
        assert callable(way)
        try:
            while self._is_open:
                way()
        except Exception as error:
            # Whatever pyserial raises: `events` reports it.
            self._problem = error

    def _carry_down(self) -> None:
        if select.select([self._ours], [], [], _READ_S)[0]:
            data = os.read(self._ours, _MAX_BYTES)
            with self._lock:  # so that nothing from the server follows a cut
                if self._carries:
                    self._write(data)

    def _write(self, data: bytes) -> None:
        self._port.write(data)
        self._events += self._language.said(data, time.monotonic())

    def _carry_up(self) -> None:
        data = self._port.read(max(1, min(self._port.in_waiting, _MAX_BYTES)))
        if not data:
            return
        at_s = time.monotonic()
        with self._lock:
            self._events += self._language.told(data, at_s)
            if self._carries:
                with contextlib.suppress(BlockingIOError):  # no server reads: drop it
                    os.write(self._ours, data)
