"""What the goals are judged by: ours again and again, beside it the peers.

Where a goal compares, the peers are measured as often as ours; elsewhere they stand beside it for
the reader and are measured once, for they are no reason for the half hour to become an hour.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Final

from e2e.lab import plan
from e2e.lab.cell import Cell

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.lab.cell import SystemName

REPEATS: Final = 3
PEERS: Final[tuple[SystemName, ...]] = ("stock", "livekit")
OURS: Final[tuple[SystemName, ...]] = ("operator", "audio-master")
SHORT_S: Final = 20.0
CHANGING_S: Final = 32.0
"""The link of step-down is whole again 10 s after its changes begin; 15 s and more to watch."""
STEADY_S: Final = 60.0
LONG_S: Final = 300.0
LONGEST_S: Final = 600.0
SLOW_IN: Final = 10
"""One of so many observers is behind a modem."""
CORES_FOR_ALL: Final = 4
"""With fewer the server, its crowd, the browser and the link would measure each other."""


def planned(*, long: bool = False, repeats: int = REPEATS, only: Sequence[str] = ()) -> list[Cell]:
    """Plan them; with `long` for 5 and 10 min where that is the goal, and for both roles."""
    again = [*_ours(long=long), *_compared()]
    # In their places among the others, so that links and browsers are kept.
    first = plan.in_order([*again, *_beside()], only)
    rest = plan.in_order(again, only)
    return [
        cell.model_copy(update={"repeat": repeat})
        for repeat in range(repeats)
        for cell in (rest if repeat else first)
    ]


def crowds(*, long: bool = False) -> tuple[int, int]:
    """How many observers there are in the smaller and the larger crowd.

    With `long` all hundred, whatever the machine; the report says how busy it was.
    """
    return (10, 100) if long or (os.cpu_count() or 1) >= CORES_FOR_ALL else (10, 40)


def stock_crowds() -> tuple[int, int]:
    """How many observers stock has: one encoder each, and 8 saturate a core."""
    return 1, 3


def _ours(*, long: bool) -> Iterator[Cell]:
    steady_s, longest_s = (LONG_S, LONGEST_S) if long else (STEADY_S, STEADY_S)
    yield _cell("same-machine", "operator")
    yield _cell("same-machine", "audio-master", STEADY_S if long else SHORT_S + 5)
    yield _cell("internet-5m", "operator")
    yield _cell("internet-5m", "audio-master", steady_s)
    yield _cell("modem-56k", "operator", steady_s, drives=True)
    yield _cell("satellite", "audio-master", longest_s)
    for system in OURS if long else OURS[:1]:
        yield _cell("wireless-1m", system)
        yield _cell("wifi-bad", system, STEADY_S if long else SHORT_S + 10)
        yield _cell("step-down", system, CHANGING_S)
    for observers in crowds(long=long):
        yield _crowd("operator", observers, observers // SLOW_IN)


def _compared() -> Iterator[Cell]:
    """Give the peers' cells that a goal is relative to."""
    for profile in ("same-machine", "internet-5m"):
        for system in PEERS:
            yield _cell(profile, system)
    for observers in stock_crowds():
        yield _crowd("stock", observers, 0)


def _beside() -> Iterator[Cell]:
    """Give the peers' other cells."""
    for system in PEERS:
        for profile in ("wireless-1m", "modem-56k", "wifi-bad", "satellite"):
            yield _cell(profile, system)
        yield _cell("step-down", system, CHANGING_S)


def _cell(
    profile: str, system: SystemName, seconds: float = SHORT_S, *, drives: bool = False
) -> Cell:
    return Cell(experiment="G", profile=profile, system=system, seconds=seconds, drives=drives)


def _crowd(system: SystemName, observers: int, slow: int) -> Cell:
    return Cell(
        experiment="G",
        profile="same-machine",
        system=system,
        viewers=1 + observers,
        slow=slow,
        seconds=SHORT_S,
    )
