"""The long steps of the server's event loop, read from its log at level "debug"."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from wax.edge.step_watch import LONG_STEP

if TYPE_CHECKING:
    from collections.abc import Iterator

WITH_STEPS: Final[dict[str, Any]] = {"log": {"level": "debug", "format": "json"}}


@dataclass(frozen=True, slots=True)
class Step:
    """`processor_ms` is its own processor time, without waits for other programs."""

    part: str
    ms: float
    processor_ms: float
    stack: str

    def __str__(self) -> str:
        *_, last = self.stack.splitlines() or [""]
        return f"{self.processor_ms:g} of {self.ms:g} ms {self.part} {last}"


def long_steps(log: str) -> list[Step]:
    """Return the steps with more than 2 ms of processor time, the longest first."""
    found = (
        Step(one["part"], one["ms"], one["processor_ms"], one.get("stack", ""))
        for one in _lines(log)
        if one.get("event") == LONG_STEP
    )
    return sorted(found, key=lambda one: -one.processor_ms)


def _lines(log: str) -> Iterator[dict[str, Any]]:
    for line in log.splitlines():
        if line.startswith("{") and line.endswith("}"):
            yield json.loads(line)
