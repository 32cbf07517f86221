"""What a process that makes namespaces reports about itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from pydantic import TypeAdapter
from tests.link.counters import Counters  # noqa: TC002  # pydantic looks the annotation up

LATE_MS: Final = 5.0


@dataclass(frozen=True, slots=True)
class Statistics:
    """Since the link's start; `down` is from the server to the browser."""

    real_time: bool
    """Whether the forwarder runs in real time; if not, its delays are less exact."""
    down: Counters
    up: Counters
    late: int
    """Of the packets delivered both ways, those more than `LATE_MS` late: the link's own error."""

    @property
    def delivered(self) -> int:
        return self.down.packets_out + self.up.packets_out


STATISTICS: Final = TypeAdapter(Statistics)


@dataclass(frozen=True, slots=True)
class Hello:
    """The first line of a process that makes namespaces: their descriptors, or why it made none."""

    networks: dict[str, int] = field(default_factory=dict)
    in_user_namespace: bool = False
    start_s: float = 0.0
    """When time 0 of a link was."""
    refused: str = ""


HELLO: Final = TypeAdapter(Hello)
