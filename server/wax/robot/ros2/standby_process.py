"""The driver's end of the standby: a pipe each way, and a process that is restarted."""

from __future__ import annotations

import contextlib
import math
import os
import re
import subprocess
from typing import TYPE_CHECKING, Final

import structlog

from wax.machine import python_module
from wax.machine.priority import as_others
from wax.robot.ros2.standby_rules import OWES, RESTS, SILENCE_S, patience_s
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.robot.ros2.settings import Ros2Settings

_LOG = structlog.get_logger(__name__)

_COMMAND: Final = python_module.command("wax.robot.ros2.standby")
_READ_BYTES: Final = 4096
_READS: Final = 32
"""More reads than a full pipe needs, so that no old message is left to be taken for a new one."""
_WORDS: Final = re.compile(rb"([0-9A-Za-z-]{1,64}) ([0-9]{1,9}|-)")
_MAX_LINE: Final = 1000
_PAUSE_S: Final = 1.0
_LEFT: Final[list[subprocess.Popen[bytes]]] = []
"""Standbys left running or killed: they must be polled for their end, or they become zombies."""
STARTS: Final = Sentence("ros2.standby_starts")


class StandbyProcess:
    """Starts the standby and restarts it, also when it freezes; used by one thread."""

    def __init__(self, settings: Ros2Settings, clock: Clock) -> None:
        self._settings = settings
        self._clock = clock
        self._process: subprocess.Popen[bytes] | None = None
        self._started_s = -_PAUSE_S
        self._heard_s = 0.0
        self._rest = b""
        self._reaches: int | None = 0
        self.speaks_at_s = math.inf
        """When it will send standstill for us, unless it gets a message before."""
        self.guid = ""
        self.guids: set[str] = set()
        """The GUIDs of all standbys so far: the network reports a killed one for seconds."""

    @property
    def is_ready(self) -> bool:
        """Whether it could stop the robot, according to its last report."""
        return bool(self.guid) and self._reaches != 0

    def poll(self) -> Sentence | None:
        """Start it if it does not run; return why it could not stop the robot, if so."""
        if self._process is not None and self._process.poll() is not None:
            self.leave()  # the next check starts another; sending standstill comes first
        elif self._process is None:
            self._start()
        self._read()  # first, since its messages were queued while this process slept
        self._end_if_mute()
        return None if self.is_ready else STARTS

    def report(self, *, owes: bool) -> None:
        """Report, with each message to the robot, whether it would need standstill if we froze."""
        if self._process is None or self._process.stdin is None:
            return
        self.speaks_at_s = self._clock.now_s() + SILENCE_S if owes else math.inf
        # The next check finds one that has ended; silence reveals one that does not read.
        with contextlib.suppress(OSError):
            self._process.stdin.write(OWES if owes else RESTS)

    def leave(self) -> None:
        """Leave the sending to the standby from now on; it ends by itself."""
        if self._process is not None:
            _close(self._process)
            _LEFT.append(self._process)
        self.speaks_at_s = math.inf
        self._process, self._rest, self.guid, self._reaches = None, b"", "", 0

    def _start(self) -> None:
        _LEFT[:] = [left for left in _LEFT if left.poll() is None]
        if self._clock.now_s() - self._started_s < _PAUSE_S:
            return
        self._started_s = self._heard_s = self._clock.now_s()
        try:
            with as_others():
                process = subprocess.Popen(
                    _COMMAND,
                    bufsize=0,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    env=python_module.environment(),
                    start_new_session=True,  # a signal to our process group must not end it
                )
        except OSError:
            return  # the sentence stays until it starts
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(OSError):  # it has ended, which the next check finds
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
            *lines, self._rest = (self._rest + heard).split(b"\n")
            self._rest = self._rest[-_MAX_LINE:]
            for line in lines:
                self._hear(line)

    def _hear(self, line: bytes) -> None:
        """Parse how many subscribers it reaches; ignore other lines, which a library may print."""
        found = _WORDS.fullmatch(line)
        if found is not None:
            self.guid = found[1].decode()
            self.guids.add(self.guid)
            self._reaches = None if found[2] == b"-" else int(found[2])
            self._heard_s = self._clock.now_s()

    def _end_if_mute(self) -> None:
        """Kill a standby that is frozen or hangs; the next check starts another.

        Closing its pipes would not do: a frozen one that wakes up would send standstill to a robot
        that somebody else drives.
        """
        if self._process is None:
            return
        mute_s = self._clock.now_s() - self._heard_s
        if mute_s >= patience_s(self._reaches, self._settings.reopen_s):
            _LOG.warning("the standby hangs; it is started anew", mute_s=round(mute_s, 1))
            self._process.kill()
            self.leave()


def _close(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):
                pipe.close()
