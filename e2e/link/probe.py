"""Probe traffic, run at both ends at once: sends numbered datagrams, notes those that come.

``python -m e2e.link.probe OWN-ADDRESS OTHER-ADDRESS`` writes an empty line when it listens,
reads a `Plan` as JSON and writes a `Record` as JSON. Both ends share one monotonic clock, so delays
are one way.
"""

from __future__ import annotations

import select
import socket
import struct
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from pydantic import TypeAdapter

from e2e.link.priority import be_first

PORT: Final = 7700
HEADER_BYTES: Final = 28
"""IP and UDP: a datagram of so many more bytes is what the link counts."""

_NUMBER_AND_TIME: Final = struct.Struct("!Id")
LEAST_BYTES: Final = HEADER_BYTES + _NUMBER_AND_TIME.size
_BUFFER_BYTES: Final = 4 * 1024 * 1024


@dataclass(frozen=True, slots=True)
class Train:
    """Packets of `size_bytes` (headers included), one each `interval_s`, from begin to end."""

    begin_s: float
    end_s: float
    interval_s: float
    size_bytes: int


@dataclass(frozen=True, slots=True)
class Plan:
    """Monotonic times; trains one after the other."""

    trains: list[Train]
    listen_until_s: float


@dataclass(frozen=True, slots=True)
class Record:
    """When each packet was sent, by number; number, sent and received of what came, in order."""

    sent_s: list[float] = field(default_factory=list)
    came: list[tuple[int, float, float]] = field(default_factory=list)


def run(link: socket.socket, plan: Plan) -> Record:
    """Send and receive until the plan's end."""
    record = Record()
    for train in plan.trains:
        _send(link, train, record)
    _receive(link, plan.listen_until_s, record)
    return record


def _send(link: socket.socket, train: Train, record: Record) -> None:
    padding = bytes(train.size_bytes - LEAST_BYTES)
    next_s = train.begin_s
    while next_s < train.end_s:
        _receive(link, next_s, record)
        now_s = time.monotonic()
        number = len(record.sent_s)
        record.sent_s.append(now_s)
        with suppress(BlockingIOError):  # counts as lost
            link.send(_NUMBER_AND_TIME.pack(number, now_s) + padding)
        next_s += train.interval_s


def _receive(link: socket.socket, until_s: float, record: Record) -> None:
    """Note what comes until then."""
    while True:
        wait_s = until_s - time.monotonic()
        readable, _, _ = select.select([link], [], [], max(0.0, wait_s))
        if not readable and wait_s <= 0:
            return
        while readable:
            try:
                datagram = link.recv(2048)
            except BlockingIOError:
                break
            number, sent_s = _NUMBER_AND_TIME.unpack_from(datagram)
            record.came.append((number, sent_s, time.monotonic()))
        if wait_s <= 0:
            return


def main() -> None:
    own, other = sys.argv[1:]
    be_first()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            link.setsockopt(socket.SOL_SOCKET, option, _BUFFER_BYTES)
        link.bind((own, PORT))
        link.connect((other, PORT))
        link.setblocking(False)
        print(flush=True)
        plan = TypeAdapter(Plan).validate_json(sys.stdin.buffer.read())
        record = run(link, plan)
    sys.stdout.buffer.write(TypeAdapter(Record).dump_json(record))


if __name__ == "__main__":
    main()
