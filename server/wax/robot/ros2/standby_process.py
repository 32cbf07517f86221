"""The standby as the driver sees it: a pipe each way, and a process that is started again."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import sys
from typing import TYPE_CHECKING, Final

from wax.robot.ros2.standby_rules import OWES, RESTS
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.robot.ros2.settings import Ros2Settings

_COMMAND: Final = ("-P", "-m", "wax.robot.ros2.standby")
_READ_BYTES: Final = 4096
_READS: Final = 32
"""More than a pipe holds, so that what was said long ago is not taken for news later."""
_WORDS: Final = re.compile(rb"([0-9A-Za-z-]{1,64}) ([0-9]{1,9}|-)")
_MAX_LINE: Final = 1000
_PAUSE_S: Final = 1.0
_LEFT: Final[list[subprocess.Popen[bytes]]] = []
"""Those that speak for a driver that has ended: somebody must ask for their end, or they stay."""
STARTS: Final = Sentence("ros2.standby_starts")


class StandbyProcess:
    """Starts the standby and keeps it; used by one thread, `guid` by any."""

    def __init__(self, settings: Ros2Settings, clock: Clock) -> None:
        self._settings = settings
        self._clock = clock
        self._process: subprocess.Popen[bytes] | None = None
        self._started_s = -_PAUSE_S
        self._heard = b""
        self._reaches: int | None = 0
        self.guid = ""

    def look(self) -> Sentence | None:
        """Start it where it does not run; return why it could not stop the robot, if so."""
        if self._process is not None and self._process.poll() is not None:
            self._forget()
        if self._process is None:
            self._start()
        self._read()
        return STARTS if not self.guid or self._reaches == 0 else None

    def tell(self, *, owes: bool) -> None:
        """Say, with each message to the robot, whether the standby would have to speak for us."""
        if self._process is None or self._process.stdin is None:
            return
        try:
            self._process.stdin.write(OWES if owes else RESTS)
        except BlockingIOError:
            self._process.kill()  # it does not read, so it would not speak either
        except OSError:
            pass  # it has ended, which the next look finds

    def leave(self) -> None:
        """Let it speak for us from now on; it ends by itself."""
        if self._process is not None:
            process, self._process = self._process, None
            _close(process)
            _LEFT.append(process)
        self.guid = ""

    def _start(self) -> None:
        _LEFT[:] = [left for left in _LEFT if left.poll() is None]
        if self._clock.now_s() - self._started_s < _PAUSE_S:
            return
        self._started_s = self._clock.now_s()
        try:
            process = subprocess.Popen(
                [sys.executable, *_COMMAND],
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(p or "." for p in sys.path)},
                start_new_session=True,  # what ends us must not end it
            )
        except OSError:
            return  # the sentence stays until it starts
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(OSError):  # it has ended, which the next look finds
            process.stdin.write(self._settings.model_dump_json().encode() + b"\n")
        os.set_blocking(process.stdin.fileno(), False)
        os.set_blocking(process.stdout.fileno(), False)
        self._process = process

    def _read(self) -> None:
        if self._process is None or self._process.stdout is None:
            return
        for _ in range(_READS):
            heard = self._process.stdout.read(_READ_BYTES)
            if not heard:
                break
            *lines, self._heard = (self._heard + heard).split(b"\n")
            self._heard = self._heard[-_MAX_LINE:]
            for line in lines:
                self._hear(line)

    def _hear(self, line: bytes) -> None:
        """Take how many it reaches; what is no such line, as a library may print, says nothing."""
        found = _WORDS.fullmatch(line)
        if found is not None:
            self.guid = found[1].decode()
            self._reaches = None if found[2] == b"-" else int(found[2])

    def _forget(self) -> None:
        if self._process is not None:
            _close(self._process)
        self._process, self._heard, self.guid, self._reaches = None, b"", "", 0


def _close(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):
                pipe.close()
