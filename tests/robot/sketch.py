"""Boards that are driven by lines, each behind a pseudo-terminal, in a process of its own.

They are written from the originals' source and manuals, and know nothing of WAX:

- ``bridge``: ros_arduino_bridge's ROSArduinoBridge.ino (hbrobotics). One letter, up to two numbers
  separated by spaces, a carriage return; an unknown letter is answered "Invalid Command". A
  loop of 30 Hz moves the wheels; without an ``m`` for 2000 ms they stop.
- ``roboteq``: "Advanced Digital Motor Controller User Manual", serial operation. Commands end with
  a carriage return or ``_``; each is echoed until ``^ECHOF 1``, then answered ``+`` or ``-``. After
  ``^RWD`` ms without a command that begins with ``!`` the motors stop, and resume with the next
  valid one. ``!EX`` stops them until ``!MG``.
- ``mute``: reads and never answers.

``python sketch.py KIND LINK LOG`` makes LINK a link to its port and writes to LOG a line of JSON
for each command that ran and each change of its wheels, with ``t_s`` of CLOCK_MONOTONIC. Its
standard input takes ``unplug``, ``plug``, ``reset``, ``freeze`` and ``thaw``; its end ends it.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import sys
import time
import tty
from pathlib import Path
from typing import Any

LOOP_S = 1 / 30
BOOT_S = 1.0  # an Uno's boot loader


class Log:
    def __init__(self, path: str) -> None:
        self._file = Path(path).open("a", encoding="utf-8", buffering=1)  # noqa: SIM115 - its end closes it

    def say(self, event: str, **fields: Any) -> None:
        self._file.write(json.dumps({"t_s": time.monotonic(), "event": event, **fields}) + "\n")


class Wheels:
    def __init__(self, log: Log) -> None:
        self._log = log
        self.now = (0, 0)

    def turn(self, left: int, right: int, why: str, after_s: float | None = None) -> None:
        """Turn, or stop after `after_s` without a command."""
        if (left, right) != self.now:
            self.now = (left, right)
            self._log.say("wheels", left=left, right=right, why=why, after_s=after_s)


class Mute:
    """A board that reads and never answers."""

    def __init__(self, log: Log) -> None:
        self.wheels = Wheels(log)

    def hear(self, letter: str) -> str:
        return ""

    def loop(self, elapsed_s: float) -> None:
        """Nothing turns."""


class Bridge:
    AUTO_STOP_S = 2.0

    def __init__(self, log: Log) -> None:
        self._log = log
        self.wheels = Wheels(log)
        self._targets = (0, 0)
        self._last_motor_s = time.monotonic()
        self._encoders = [0.0, 0.0]
        self._clear()

    def _clear(self) -> None:
        self._command, self._arguments, self._at = "", ["", ""], 0

    def hear(self, letter: str) -> str:
        if letter == "\r":
            answer = self._run()
            self._clear()
            return answer
        if letter == " ":
            self._at += self._at < 2
        elif self._at == 0:
            self._command = letter
        else:
            self._arguments[self._at - 1] += letter
        return ""

    def _run(self) -> str:
        first, second = (_atoi(text) for text in self._arguments)
        self._log.say("command", letter=self._command, first=first, second=second)
        if self._command == "m":
            self._last_motor_s = time.monotonic()
            self._targets = (first, second)
            if self._targets == (0, 0):
                self.wheels.turn(0, 0, "told")
            return "OK\r\n"
        if self._command == "e":
            return f"{int(self._encoders[0])} {int(self._encoders[1])}\r\n"
        if self._command == "b":
            return "57600\r\n"
        return "Invalid Command\r\n"

    def loop(self, elapsed_s: float) -> None:
        if time.monotonic() - self._last_motor_s > self.AUTO_STOP_S:
            self._targets = (0, 0)
            self.wheels.turn(0, 0, "auto stop", self.AUTO_STOP_S)
        else:
            self.wheels.turn(*self._targets, why="loop")
        for at, ticks in enumerate(self.wheels.now):
            self._encoders[at] += ticks * elapsed_s / LOOP_S


class Roboteq:
    def __init__(self, log: Log) -> None:
        self._log = log
        self.wheels = Wheels(log)
        self._line = ""
        self._echoes, self._is_stopped = True, False
        self._watchdog_s, self._fed_s = 1.0, time.monotonic()
        self._wanted = (0, 0)
        self._counts = [0.0, 0.0]

    def hear(self, letter: str) -> str:
        echo = letter if self._echoes else ""
        if letter not in "\r_":
            self._line += letter
            return echo
        line, self._line = self._line.strip(), ""
        return echo + (self._run(line) if line else "")

    def _run(self, line: str) -> str:
        self._log.say("command", line=line)
        name, *numbers = line.split()
        try:
            values = [int(number) for number in numbers]
        except ValueError:
            return "-\r"
        if name == "?V" and values == [2]:
            return "V=246\r"
        if name == "?C":
            return f"C={int(self._counts[0])}:{int(self._counts[1])}\r"
        return "+\r" if self._obey(name, values) else "-\r"

    def _obey(self, name: str, values: list[int]) -> bool:
        if name == "^ECHOF":
            self._echoes = values != [1]
        elif name == "^RWD":
            self._watchdog_s = values[0] / 1000.0
        elif name == "!EX":
            self._is_stopped = True
        elif name == "!MG":
            self._is_stopped = False
        elif name == "!M" and len(values) == 2 and max(map(abs, values)) <= 1000:
            self._wanted = (values[0], values[1])
        else:
            return False
        if name.startswith("!"):
            self._fed_s = time.monotonic()
            self._move()
        return True

    def _move(self) -> None:
        is_fed = not self._watchdog_s or time.monotonic() - self._fed_s < self._watchdog_s
        if self._is_stopped:
            self.wheels.turn(0, 0, "emergency stop")
        elif not is_fed:
            self.wheels.turn(0, 0, "watchdog", self._watchdog_s)
        else:
            self.wheels.turn(*self._wanted, why="told")

    def loop(self, elapsed_s: float) -> None:
        self._move()
        for at, share in enumerate(self.wheels.now):
            self._counts[at] += share * elapsed_s * 4


KINDS: dict[str, type[Mute | Bridge | Roboteq]] = {
    "bridge": Bridge,
    "roboteq": Roboteq,
    "mute": Mute,
}


def _atoi(text: str) -> int:
    """Convert as C's atoi: leading digits with a sign, else 0."""
    digits = ""
    for letter in text:
        if not (letter.isdigit() or (letter in "+-" and not digits)):
            break
        digits += letter
    return int(digits) if digits.strip("+-") else 0


class Cable:
    """A pseudo-terminal, with its port at `link` while plugged in."""

    def __init__(self, link: str) -> None:
        self._link = Path(link)
        self._ends: tuple[int, int] | None = None

    def plug(self) -> None:
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        self._ends = master, slave
        self._link.symlink_to(os.ttyname(slave))

    def unplug(self) -> None:
        if self._ends is not None:
            self._link.unlink()
            for end in self._ends:
                os.close(end)
        self._ends = None

    @property
    def descriptors(self) -> list[int]:
        return [self._ends[0]] if self._ends else []

    def read(self) -> str:
        with contextlib.suppress(BlockingIOError, OSError):
            return os.read(self.descriptors[0], 4096).decode("latin-1")
        return ""

    def write(self, text: str) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self.descriptors[0], text.encode("latin-1"))


class Bench:
    """A board and its cable, commanded by standard input."""

    def __init__(self, kind: str, link: str, log_path: str) -> None:
        self._kind, self._log, self._cable = kind, Log(log_path), Cable(link)
        self._board = KINDS[kind](self._log)
        self._boots_until_s, self._is_frozen, self._has_ended = 0.0, False, False

    def run(self) -> None:
        self._cable.plug()
        self._log.say("plugged")
        looped_s = time.monotonic()
        while not self._has_ended:
            pause_s = max(0.0, looped_s + LOOP_S - time.monotonic())
            ready, _, _ = select.select([0, *self._cable.descriptors], [], [], pause_s)
            if 0 in ready:
                self._take(os.read(0, 256).decode())
            if self._is_frozen:
                time.sleep(LOOP_S)
                continue
            self._listen()
            now_s = time.monotonic()
            if now_s - looped_s >= LOOP_S:
                self._board.loop(now_s - looped_s)
                looped_s = now_s
        self._cable.unplug()

    def _take(self, commands: str) -> None:
        self._has_ended = not commands
        for command in commands.split():
            if command == "reset":
                self._board.wheels.turn(0, 0, "reset")
                self._board = KINDS[self._kind](self._log)
                self._boots_until_s = time.monotonic() + BOOT_S
            elif command in ("plug", "unplug"):
                getattr(self._cable, command)()
            else:
                self._is_frozen = command == "freeze"
            self._log.say(command)

    def _listen(self) -> None:
        heard = self._cable.read() if self._cable.descriptors else ""
        if time.monotonic() >= self._boots_until_s:
            answer = "".join(self._board.hear(letter) for letter in heard)
            if answer:
                self._cable.write(answer)


if __name__ == "__main__":
    Bench(*sys.argv[1:]).run()
