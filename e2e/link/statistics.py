"""What the forwarder tells about itself."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import Final

from tests.link.counters import Counters  # noqa: TC002  # pydantic looks the annotation up

LATE_MS: Final = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


@dataclass(slots=True)
class Lateness:
    """How long after their time packets were delivered: the link's own error."""

    up_to_ms: list[float] = field(default_factory=lambda: list(LATE_MS))
    packets: list[int] = field(default_factory=lambda: [0] * (len(LATE_MS) + 1))
    """How many were at most so late; the last number is of those beyond."""
    worst_ms: float = 0.0

    def add(self, late_ms: float) -> None:
        self.packets[bisect_left(LATE_MS, late_ms)] += 1
        self.worst_ms = max(self.worst_ms, late_ms)


@dataclass(frozen=True, slots=True)
class Statistics:
    """Since the link's start; `down` is from the server to the browser."""

    running_s: float
    cpu_s: float
    real_time: bool
    """Whether the forwarder goes before other processes; if not, trust delays less."""
    down: Counters
    up: Counters
    down_late: Lateness
    up_late: Lateness


@dataclass(frozen=True, slots=True)
class Hello:
    """The forwarder's first line: its descriptors of the namespaces, and when time 0 was."""

    start_s: float
    server_network: int
    browser_network: int
    in_user_namespace: bool


@dataclass(frozen=True, slots=True)
class Refusal:
    """The forwarder's only line when there is no link."""

    refused: str
