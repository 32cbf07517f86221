"""The process that is the link: holds both namespaces, moves packets between their TUN devices.

``python -m e2e.link.forwarder`` reads the profile as one line of JSON, answers with one line
(`Hello`), and then answers each line ``statistics`` or ``start_changes`` with one. Its standard
input ends when its owner has ended. Then it ends everything in the namespaces, and itself; the
namespaces and devices disappear with it.
"""

from __future__ import annotations

import gc
import json
import math
import os
import select
import signal
import sys
import time
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from tests.link.model import Direction
from tests.link.profile import Profile

from e2e.link import leftovers, namespace
from e2e.link.namespace import open_tun
from e2e.link.statistics import LATE_MS, Hello, Statistics
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from collections.abc import Callable

_BATCH: Final = 32
_READ_BYTES: Final = 2048
"""More than the MTU; a packet is read whole, or its end is lost."""
_USER_NAMESPACE: Final = "/proc/self/ns/user"


class Way:
    """One direction: from a device, through the model, to the other device."""

    def __init__(self, source: int, sink: int, direction: Direction) -> None:
        self.source = source
        self.direction = direction
        self.late = 0
        self._sink = sink

    def take(self) -> None:
        """Read the waiting packets. Each has its own time stamp: a batch may take a millisecond."""
        with suppress(BlockingIOError):
            for _ in range(_BATCH):
                self.direction.arrive(os.read(self.source, _READ_BYTES), time.monotonic())

    def deliver(self) -> None:
        now_s = time.monotonic()
        for due_s, packet in self.direction.due(now_s):
            self.late += (now_s - due_s) * 1000 > LATE_MS
            os.write(self._sink, packet)


class Forwarder:
    def __init__(self, down: Way, up: Way, *, real_time: bool) -> None:
        self._down = down
        self._up = up
        self._real_time = real_time
        self._asked = b""

    def run(self, control: int, answer: Callable[[Any], None]) -> None:
        ways = {self._down.source: self._down, self._up.source: self._up}
        watched = [control, *ways]
        while True:
            next_s = min(self._down.direction.next_s(), self._up.direction.next_s())
            # Not epoll: its timeouts are whole milliseconds.
            wait_s = None if next_s == math.inf else max(0.0, next_s - time.monotonic())
            readable, _, _ = select.select(watched, [], [], wait_s)
            for source in readable:
                if source != control:
                    ways[source].take()
                elif not self._obey(control, answer):
                    return
            self._down.deliver()
            self._up.deliver()

    def _obey(self, control: int, answer: Callable[[Any], None]) -> bool:
        """Answer the lines that have arrived; return False at the end."""
        piece = os.read(control, 4096)
        *lines, self._asked = (self._asked + piece).split(b"\n")
        for line in lines:
            answer(self._statistics() if line == b"statistics" else self._start_changes())
        return bool(piece)

    def _start_changes(self) -> float:
        now_s = time.monotonic()
        self._down.direction.start_changes(now_s)
        self._up.direction.start_changes(now_s)
        return now_s

    def _statistics(self) -> dict[str, Any]:
        return asdict(
            Statistics(
                real_time=self._real_time,
                down=self._down.direction.counters,
                up=self._up.direction.counters,
                late=self._down.late + self._up.late,
            )
        )


def main() -> int:
    control = sys.stdin.fileno()
    # Unbuffered, because the lines after the first are read when `select` announces them.
    with open(control, "rb", buffering=0, closefd=False) as lines:
        profile = Profile.model_validate_json(lines.readline())
    user = Path(_USER_NAMESPACE).readlink()
    try:
        server, server_tun = _end(namespace.SERVER_ADDRESS)
        browser, browser_tun = _end(namespace.BROWSER_ADDRESS)
    except NotRunError as error:
        _answer(asdict(Hello(refused=str(error))))
        return 1
    start_s, real_time = time.monotonic(), be_first()
    begin: Any = {"seed": profile.seed, "start_s": start_s}
    forwarder = Forwarder(
        Way(server_tun, browser_tun, Direction(profile.down, way="down", **begin)),
        Way(browser_tun, server_tun, Direction(profile.up, way="up", **begin)),
        real_time=real_time,
    )
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    gc.disable()  # nothing here makes cycles, and a collection would delay packets
    try:
        networks = {"server": server, "browser": browser}
        _answer(asdict(Hello(networks, Path(_USER_NAMESPACE).readlink() != user, start_s)))
        forwarder.run(control, _answer)
    finally:
        ours = {leftovers.namespace_of(server), leftovers.namespace_of(browser)}
        leftovers.end_all(ours, but=os.getpid())
    return 0


def _end(address: str) -> tuple[int, int]:
    """Make one end; return descriptors of its namespace and its device."""
    network = namespace.enter_new_network()
    device = open_tun(namespace.DEVICE)
    namespace.configure(namespace.DEVICE, f"{address}/24")
    return network, device


def _answer(value: Any) -> None:
    print(json.dumps(value), flush=True)


def be_first() -> bool:
    """Run this process in real time where that is allowed, as to root; return whether it does."""
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except PermissionError:
        return False
    return True


if __name__ == "__main__":
    sys.exit(main())
