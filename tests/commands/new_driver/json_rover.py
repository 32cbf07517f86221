"""The rover of the walk-through: lines of JSON on a serial port, here a pseudo-terminal."""

from __future__ import annotations

import json
import os
import select
import threading
import time
import tty
from typing import Final

TTL_S: Final = 0.2
VOLTAGE: Final = 11.8


class JsonRover:
    """Turns its wheels as it is told, and stands when it has heard nothing for `TTL_S`."""

    def __init__(self) -> None:
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        self.port = os.ttyname(self._theirs)
        self.wheels = (0.0, 0.0)
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._live, name="json rover")
        self._thread.start()

    @property
    def moves(self) -> bool:
        return self.wheels != (0.0, 0.0)

    def close(self) -> None:
        self._stopping.set()
        self._thread.join()
        os.close(self._ours)
        os.close(self._theirs)

    def _live(self) -> None:
        heard, heard_s = b"", time.monotonic()
        while not self._stopping.is_set():
            if select.select([self._ours], [], [], 0.01)[0]:
                *lines, heard = (heard + os.read(self._ours, 1000)).split(b"\n")
                for line in lines:
                    told = json.loads(line)
                    self.wheels, heard_s = (told["L"], told["R"]), time.monotonic()
                    self._answer()
            elif time.monotonic() - heard_s > TTL_S and self.moves:
                self.wheels = (0.0, 0.0)
                self._answer()

    def _answer(self) -> None:
        left, right = self.wheels
        os.write(self._ours, json.dumps({"L": left, "R": right, "V": VOLTAGE}).encode() + b"\n")
