"""Whether what is sent to a topic arrives here: this server sends itself a message by each. Pure.

A broker may grant a subscription and deliver nothing (mosquitto's access lists do), and a button at
home that does nothing looks like one that works.
"""

from __future__ import annotations

import re
import secrets
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.house import commands

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

PERIOD_S: Final = 30.0
LIMIT_S: Final = 3.0
"""What comes back later is lost: a Stop would come as late."""
AGAIN_S: Final = 5.0
"""After one that is lost."""
_SHAPE: Final = re.compile(rb"wax-probe ([0-9a-f]{32}) ([0-9]{1,9}) *")
_STOP_BYTES: Final = 1024
"""Servers that know no probes let their broker send no packet as large: they would stop at it."""


@dataclass(slots=True)
class _Way:
    """To one topic; `number` is the newest probe's, `is_open` is None until the first is over."""

    number: int = 0
    is_out: bool = False
    sent_s: float = float("-inf")
    is_open: bool | None = None


class Probes:
    """Of one connection, to these topics."""

    def __init__(self, topics: Iterable[str]) -> None:
        self._own = secrets.token_hex(16).encode()
        self._ways = {topic: _Way() for topic in topics}

    def due(self, now_s: float) -> Iterator[tuple[str, bytes]]:
        """Yield what is to be sent now, each to its topic; what is not sent is lost."""
        for topic, way in self._ways.items():
            if way.is_out and now_s - way.sent_s > LIMIT_S:
                way.is_out = way.is_open = False
            if not way.is_out and now_s - way.sent_s >= (PERIOD_S if way.is_open else AGAIN_S):
                way.number += 1
                way.is_out, way.sent_s = True, now_s
                yield topic, _sized(topic, b"wax-probe %b %d" % (self._own, way.number))

    def take(self, topic: str, payload: bytes, now_s: float) -> bool:
        """Return whether a message is a probe, which asks for nothing; note what it proves.

        Another server's at the same topics, and the doctor's, are probes as well: they must not
        stop this robot. Only the newest of our own proves anything.
        """
        found = _SHAPE.fullmatch(payload)
        if found is None or len(payload) != len(_sized(topic, found[0].rstrip(b" "))):
            return False
        way = self._ways.get(topic)
        is_newest = way is not None and way.is_out and int(found[2]) == way.number
        if way is not None and is_newest and secrets.compare_digest(found[1], self._own):
            way.is_out, way.is_open = False, now_s - way.sent_s <= LIMIT_S
        return True

    def is_open(self, topic: str) -> bool:
        """Whether the newest probe that is over came back by this topic."""
        return self._ways[topic].is_open is True

    def closed(self) -> list[str]:
        """Return the topics by which it did not."""
        return [topic for topic, way in self._ways.items() if way.is_open is False]

    def are_tried(self) -> bool:
        """Whether the first probe of every topic is over."""
        return all(way.is_open is not None for way in self._ways.values())


def _sized(topic: str, probe: bytes) -> bytes:
    """Return it as long as it is sent by this topic."""
    return probe.ljust(_STOP_BYTES) if topic.endswith(f"/{commands.STOP}/set") else probe
