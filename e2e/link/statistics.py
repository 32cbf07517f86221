"""What a process that makes namespaces tells about itself."""

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
    """Whether the forwarder goes before other processes; if not, trust delays less."""
    down: Counters
    up: Counters
    late: int
    """Of those delivered both ways, more than `LATE_MS` after their time: the link's own error."""

    @property
    def delivered(self) -> int:
        return self.down.packets_out + self.up.packets_out


STATISTICS: Final = TypeAdapter(Statistics)


@dataclass(frozen=True, slots=True)
class Hello:
    """The first line of who makes namespaces: their descriptors by name, or why there are none."""

    networks: dict[str, int] = field(default_factory=dict)
    in_user_namespace: bool = False
    start_s: float = 0.0
    """When time 0 of a link was."""
    refused: str = ""


HELLO: Final = TypeAdapter(Hello)
