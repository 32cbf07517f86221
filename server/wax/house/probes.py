"""Tests whether messages to a topic arrive here: this server sends itself one by each. Pure.

A broker may grant a subscription and deliver nothing (mosquitto does, by its access lists), and a
dead button at home looks like one that works.
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
"""A probe that returns later counts as lost: a Stop would be as late."""
AGAIN_S: Final = 5.0
"""The period after a probe that was lost."""
_SHAPE: Final = re.compile(rb"wax-probe ([0-9a-f]{32}) ([0-9]{1,9}) *")
_STOP_BYTES: Final = 1024
"""Older servers would obey a probe as a Stop, but ask their broker for no packet this large."""


@dataclass(slots=True)
class _Way:
    """One topic's state; `number` is its newest probe's, `is_open` is None until one is over."""

    number: int = 0
    is_out: bool = False
    sent_s: float = float("-inf")
    is_open: bool | None = None


class Probes:
    """The probes of one connection, to these topics."""

    def __init__(self, topics: Iterable[str]) -> None:
        self._own = secrets.token_hex(16).encode()
        self._ways = {topic: _Way() for topic in topics}

    def due(self, now_s: float) -> Iterator[tuple[str, bytes]]:
        """Yield the topics and probes to send now; a probe that is not sent counts as lost."""
        for topic, way in self._ways.items():
            if way.is_out and now_s - way.sent_s > LIMIT_S:
                way.is_out = way.is_open = False
            if not way.is_out and now_s - way.sent_s >= (PERIOD_S if way.is_open else AGAIN_S):
                way.number += 1
                way.is_out, way.sent_s = True, now_s
                yield topic, _sized(topic, b"wax-probe %b %d" % (self._own, way.number))

    def consume(self, topic: str, payload: bytes, now_s: float) -> bool:
        """Return whether a message is a probe rather than a command, and note what it proves.

        The probes of the doctor and of another server with the same topics count as such, so that
        they do not stop this robot; only the newest of our own proves that commands arrive.
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
        """Whether the last finished probe came back by this topic."""
        return self._ways[topic].is_open is True

    def closed(self) -> list[str]:
        """Return the topics whose last finished probe was lost."""
        return [topic for topic, way in self._ways.items() if way.is_open is False]

    def are_tried(self) -> bool:
        """Whether every topic's first probe is over."""
        return all(way.is_open is not None for way in self._ways.values())


def _sized(topic: str, probe: bytes) -> bytes:
    """Return a probe padded to the size used at this topic."""
    return probe.ljust(_STOP_BYTES) if topic.endswith(f"/{commands.STOP}/set") else probe
