"""What today's policies are asked for, over which links, and how it is judged.

Where a goal compares, the peers are measured as often as ours; elsewhere they stand beside it for
the reader and are measured once, for they are no reason for the half hour to become an hour.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Final

from e2e.delay import judging, plan
from e2e.delay.cell import Cell
from e2e.delay.judging import Goal
from e2e.delay.names import AGE, GIVEN, PEERS, SYSTEMS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.delay.cell import SystemName
    from e2e.measure.row import Row

REPEATS: Final = 3
SHORT_S: Final = 20.0
CHANGING_S: Final = 32.0
"""The link of step-down is whole again 10 s after its changes begin; 15 s and more to watch."""
STEADY_S: Final = 60.0
LONG_S: Final = 300.0
LONGEST_S: Final = 600.0
SLOW_IN: Final = 10
"""One in this many observers is behind a modem."""
CORES_FOR_ALL: Final = 4
"""With fewer the server, its crowd, the browser and the link would measure each other."""
NO_DRIFT_MS: Final = 20.0
"""A minute: what the instrument does not tell from none in a cell of a minute."""
STOCK_CROWDS: Final = (1, 3)
"""How many observers stock has: one encoder each, and 8 saturate a core."""

NOTES: Final = (
    "Judged is the median over the repetitions. Where a goal is not relative to the peers, they "
    "were measured once.",
    AGE,
    "Driving: the operator’s page holds a key and sends 20 set-points a second; the commands’ "
    "round trip is that of the pings that share the channel with them.",
    "A further observer’s cost is the difference of the server’s CPU between two crowds of one "
    "repetition, divided by how many more there were; nothing is extrapolated.",
    *GIVEN,
)
_COLUMNS: Final[judging.Columns] = {
    "WAX": lambda goal, cell: cell.system == goal.system,
    **judging.columns_of(PEERS),
}
COLUMNS: Final = tuple(_COLUMNS)
_BETTER: Final[dict[str, Any]] = {"of": tuple(SYSTEMS[peer] for peer in PEERS)}


def goals() -> Iterator[Goal]:
    here: Final = "same-machine"
    both: tuple[SystemName, ...] = ("operator", "audio-master")
    yield Goal(here, "operator", "picture_age_p50_ms", 20, times=0.5, **_BETTER)
    yield Goal(here, "operator", "picture_age_p95_ms", 40)
    yield Goal("internet-5m", "audio-master", "pauses", 0)
    for system in both:
        yield Goal("wireless-1m", system, "pictures_640_per_s", at_least=25)
        yield Goal("wireless-1m", system, "picture_age_p95_ms", 150)
        yield Goal("wireless-1m", system, "pauses", 0)
    for name, limit in (
        ("concealed_percent", 1.0),
        ("picture_age_p95_ms", 600),
        ("picture_drift_ms_per_min", NO_DRIFT_MS),
        ("sound_drift_ms_per_min", NO_DRIFT_MS),
        ("command_round_trip_p95_ms", 300),
    ):
        yield Goal("modem-56k", "operator", name, limit, drives=True)
    yield Goal("modem-56k", "operator", "pictures_160_per_s", at_least=5, drives=True)
    yield Goal("modem-56k", "operator", "set_points_per_s", at_least=18, drives=True)
    for system in both:
        yield Goal("wifi-bad", system, "concealed_percent", 1.0)
        yield Goal("wifi-bad", system, "longest_freeze_ms", 300)
    for system in both:
        yield Goal("step-down", system, "fresh_after_ms", 2000)
        yield Goal("step-down", system, "step_pause_ms", 300)
        yield Goal("step-down", system, "full_after_ms", 15_000)
    yield Goal("satellite", "audio-master", "breaks", 0)
    yield Goal("satellite", "audio-master", "joined_skew_p95_ms", 20)
    yield Goal(here, "operator", "server_cpu", times=1 / 25, kind="cost", **_BETTER)
    yield Goal(here, "operator", "picture_age_p95_ms", 5, kind="crowd")


def planned(*, long: bool = False, repeats: int = REPEATS, only: Sequence[str] = ()) -> list[Cell]:
    """Plan the cells; with `long` for 5 and 10 min where that is the goal, and for both roles."""
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

    With `long` all hundred, whatever the machine; the row says how busy it was.
    """
    return (10, 100) if long or (os.cpu_count() or 1) >= CORES_FOR_ALL else (10, 40)


def derive(rows: Sequence[Row]) -> list[Row]:
    """Judge every goal of which there is a cell of ours."""
    return judging.derive(goals(), _COLUMNS, rows)


def _ours(*, long: bool) -> Iterator[Cell]:
    steady_s, longest_s = (LONG_S, LONGEST_S) if long else (STEADY_S, STEADY_S)
    both: tuple[SystemName, ...] = ("operator", "audio-master")
    yield _cell("same-machine", "operator")
    yield _cell("internet-5m", "audio-master", steady_s)
    yield _cell("modem-56k", "operator", steady_s, drives=True)
    yield _cell("satellite", "audio-master", longest_s)
    for system in both if long else both[:1]:
        yield _cell("wireless-1m", system)
        yield _cell("wifi-bad", system, STEADY_S if long else SHORT_S + 10)
        yield _cell("step-down", system, CHANGING_S)
    for observers in crowds(long=long):
        yield _crowd("operator", observers, observers // SLOW_IN)


def _compared() -> Iterator[Cell]:
    """Give the peers' cells that a goal is relative to."""
    for system in PEERS:
        yield _cell("same-machine", system)
    for observers in STOCK_CROWDS:
        yield _crowd("stock", observers, 0)


def _beside() -> Iterator[Cell]:
    """Give the peers' other cells: of LiveKit as its quick start has it."""
    peers: tuple[SystemName, ...] = ("stock", "livekit")
    for system in peers:
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
