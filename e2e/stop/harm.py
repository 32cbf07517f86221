"""The senders on a bad channel, damaged texts, and invalid texts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from random import Random

    from e2e.stop.operator import RawOperator
    from e2e.stop.stage import Stage

STOP: Final = '{"type":"stop"}'
NO_STOPS: Final = (
    '"stop"',
    '["stop"]',
    '{"stop":1}',
    '{"type":["stop"]}',
    '{"type":"Stop"}',
    '{"type":"stop","really":true}',
)

NO_COMMANDS: Final[tuple[dict[str, Any], ...]] = (
    {"held": None},
    {"held": 1},
    {"held": "true"},
    {"linear": -1.5},
    {"linear": -math.inf},
    {"linear": math.nan},
    {"linear": None},
    {"linear": "-1.0"},
    {"sent_server_ms": math.nan},
    {"axes": {"pan": -2.0}},
    {"one column too many": 0},
)
"""Each of these fields makes a correct command invalid."""


def no_releases(right: dict[str, Any]) -> tuple[dict[str, Any], ...]:
    """Return fields, each of which makes this correct release invalid."""
    stop, sent_ms = right["stop"], right["sent_server_ms"]
    return (
        {"really": True},
        {"type": "Release"},
        {"stop": str(stop)},
        {"stop": stop + 0.5},
        {"stop": None},
        {"sent_server_ms": str(sent_ms)},
        {"sent_server_ms": None},
        {"sent_server_ms": math.nan},
    )


def corrupted(text: str, random: Random) -> str:
    """Damage a text so that it is invalid: truncated, split, doubled, or with a bit flipped."""
    at = random.randrange(len(text))
    match random.randrange(4):
        case 0:
            return text[: max(1, at)]
        case 1:
            return text[:at] + random.choice("{}\x00\\") + text[at:]
        case 2:
            return text + random.choice(("", ",", "\n")) + text
        case _:
            return text[:at] + chr(ord(text[at]) ^ 0x80) + text[at + 1 :]


@dataclass(frozen=True, slots=True)
class Channel:
    """The channel between `operator`, a `stranger` and the stage's server; `random` chooses."""

    stage: Stage
    operator: RawOperator
    stranger: RawOperator
    random: Random

    def damaged(self, text: str) -> str | bytes:
        """Corrupt a text, and send every second one as binary."""
        found = corrupted(text, self.random)
        return self.random.choice((found, found.encode()))

    def some_ms(self, least: float, most: float) -> float:
        """Draw a time, short or long with equal chance."""
        return math.exp(self.random.uniform(math.log(least), math.log(most)))
