"""What today's policies are asked for, over which links, and how it is judged.

Where a goal compares, the peers are measured as often as ours; elsewhere they stand beside it for
the reader and are measured once, for they are no reason for the half hour to become an hour.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from e2e.lab import plan
from e2e.lab.cell import Cell
from e2e.lab.found import apparatus, found, is_never, median, on, values, where
from e2e.lab.measures import MEASURES
from e2e.lab.names import AGE, GIVEN, PEERS, SYSTEMS
from e2e.measure.row import Row
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.lab.cell import SystemName
    from e2e.lab.found import Found

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

COLUMNS: Final = ("WAX", *(SYSTEMS[peer] for peer in PEERS))
NOTES: Final = (
    "Judged is the median over the repetitions. Where a goal is not relative to the peers, they "
    "were measured once.",
    AGE,
    "Age of the sound: from capture to the ear, a sound device (PulseAudio’s null sink) whose "
    "output is recorded, so that the browser’s way to the device is included.",
    "Driving: the operator’s page holds a key and sends 20 set-points a second; the commands’ "
    "round trip is that of the pings that share the channel with them.",
    "A further observer’s cost is the difference of the server’s CPU between two crowds of one "
    "repetition, divided by how many more there were; nothing is extrapolated.",
    *GIVEN,
)
_WHO: Final[dict[SystemName, str]] = {"operator": "who drives", "audio-master": "an observer"}


@dataclass(frozen=True, slots=True)
class Goal:
    """`profile` and `system` are whose cells; judged is the median of `measure` over them.

    It is `at_most` or `at_least` that, and at most `of_peer` times the better peer's. Of what has
    a sign, as a drift, the size is judged.
    """

    profile: str
    system: SystemName
    measure: str
    at_most: float | None = None
    at_least: float | None = None
    of_peer: float | None = None
    kind: Literal["cells", "cost", "crowd"] = "cells"


def goals() -> Iterator[Goal]:
    here: Final = "same-machine"
    both: tuple[SystemName, ...] = ("operator", "audio-master")
    yield Goal(here, "operator", "picture_age_p50_ms", 20, of_peer=0.5)
    yield Goal(here, "operator", "picture_age_p95_ms", 40)
    yield Goal(here, "operator", "sound_age_p50_ms", 80)
    yield Goal(here, "audio-master", "joined_skew_p95_ms", 20)
    yield Goal(here, "audio-master", "sound_age_p50_ms", 90)
    yield Goal("internet-5m", "audio-master", "pauses", 0)
    yield Goal("internet-5m", "audio-master", "sound_age_p50_ms", 160)
    yield Goal("internet-5m", "audio-master", "joined_skew_p95_ms", 20)
    yield Goal("internet-5m", "operator", "picture_age_p95_ms", of_peer=0.7)
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
        yield Goal("modem-56k", "operator", name, limit)
    yield Goal("modem-56k", "operator", "pictures_160_per_s", at_least=5)
    yield Goal("modem-56k", "operator", "set_points_per_s", at_least=18)
    for system in both:
        yield Goal("wifi-bad", system, "concealed_percent", 1.0)
        yield Goal("wifi-bad", system, "longest_freeze_ms", 300)
    for system in both:
        yield Goal("step-down", system, "fresh_after_ms", 2000)
        yield Goal("step-down", system, "step_pause_ms", 300)
        yield Goal("step-down", system, "full_after_ms", 15_000)
    yield Goal("satellite", "audio-master", "breaks", 0)
    yield Goal("satellite", "audio-master", "joined_skew_p95_ms", 20)
    yield Goal(here, "operator", "server_cpu", of_peer=1 / 25, kind="cost")
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
    cells = found(rows)
    judged = [judge(goal, cells) for goal in goals() if _cells(goal, cells, goal.system)]
    return [*apparatus(rows), *judged]


def judge(goal: Goal, cells: Sequence[Found]) -> Row:
    """Judge one. What never came, or came with no picture, has missed it."""
    measure = MEASURES[goal.measure]
    ours = _cells(goal, cells, goal.system)
    peers = {peer: _value(goal, cells, peer) for peer in PEERS}
    value = _value(goal, cells, goal.system)
    limit = goal.at_least if goal.at_most is None else goal.at_most
    what = f"{goal.profile}, {_WHO[goal.system]}: {measure.label}"
    if goal.kind != "cells":
        what = {
            "cost": f"{goal.profile}: a further observer’s cost, of one core",
            "crowd": f"{goal.profile}, who drives: {measure.label} with the crowd, more by",
        }[goal.kind]
    met: bool | None = value is not None
    if goal.of_peer is not None:
        what += f" (≤ {goal.of_peer:.3g} × the better peer’s)"
        known = [one for one in peers.values() if one is not None]
        better = goal.of_peer * min(known) if known else None
        limit = min((one for one in (limit, better) if one is not None), default=None)
        met = met if known or value is None else None
    if met and value is not None and limit is not None:
        met = value >= limit if goal.at_least is not None else value <= limit
    numbers = _numbers(goal, cells, goal.system)
    return Row(
        key=f"{goal.profile}/{goal.system}/{goal.measure}/{goal.kind}",
        what=what,
        n=len({one.cell.repeat for one in ours}),
        unit=measure.unit.lstrip("±"),
        values={"WAX": value, **{SYSTEMS[peer]: one for peer, one in peers.items()}},
        spread=summarize(numbers) if numbers else None,
        judged="WAX",
        goal=limit,
        at_least=goal.at_least is not None,
        met=met,
        load=_load(goal, ours),
    )


def _cells(goal: Goal, cells: Sequence[Found], system: SystemName) -> list[Found]:
    here = where(
        on(cells, goal.profile, system),
        lambda cell: (cell.browser, cell.content) == ("chromium", "testcard"),
    )
    if goal.kind != "cells":
        return where(here, lambda cell: cell.viewers > 1)
    drives = goal.profile == "modem-56k" and system == "operator"
    return where(here, lambda cell: cell.viewers == 1 and cell.drives == drives)


def _value(goal: Goal, cells: Sequence[Found], system: SystemName) -> float | None:
    here = _cells(goal, cells, system)
    if goal.kind == "cells" and is_never(here, goal.measure):
        return None
    numbers = _numbers(goal, cells, system)
    return summarize(numbers).median if numbers else None


def _numbers(goal: Goal, cells: Sequence[Found], system: SystemName) -> list[float]:
    """Give one number for each repetition."""
    here = _cells(goal, cells, system)
    if goal.kind == "cells":
        return [abs(value) for value in values(here, goal.measure)]
    found_ones = []
    for repeat in sorted({one.cell.repeat for one in here}):
        again = [one for one in here if one.cell.repeat == repeat]
        few, many = (choose(again, key=lambda one: one.cell.viewers) for choose in (min, max))
        if goal.kind == "crowd":
            few = next(
                (
                    one
                    for one in on(cells, goal.profile, system)
                    if one.cell.is_alone and one.cell.repeat == repeat
                ),
                many,
            )
        low, high = few.values.get(goal.measure), many.values.get(goal.measure)
        more = many.cell.viewers - few.cell.viewers
        if low is not None and high is not None and more:
            found_ones.append((high - low) / (more if goal.kind == "cost" else 1))
    return found_ones


def _load(goal: Goal, ours: Sequence[Found]) -> str:
    """Say how long was measured, and of a crowd how many and how busy the machine was."""
    seconds = f"{max((one.cell.seconds for one in ours), default=0):g} s"
    if goal.kind == "cells":
        return seconds
    most = max(one.cell.viewers for one in ours)
    largest = [one for one in ours if one.cell.viewers == most]
    busy = median(largest, "machine_busy")
    told = "" if busy is None else f", {busy:.0f} % of the whole machine busy"
    return f"{most - 1} observers, {largest[0].cell.slow} behind a modem, {seconds}{told}"


def _ours(*, long: bool) -> Iterator[Cell]:
    steady_s, longest_s = (LONG_S, LONGEST_S) if long else (STEADY_S, STEADY_S)
    both: tuple[SystemName, ...] = ("operator", "audio-master")
    yield _cell("same-machine", "operator")
    yield _cell("same-machine", "audio-master", STEADY_S if long else SHORT_S + 5)
    yield _cell("internet-5m", "operator")
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
    for profile in ("same-machine", "internet-5m"):
        for system in PEERS:
            yield _cell(profile, system)
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
