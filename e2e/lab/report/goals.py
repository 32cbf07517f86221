"""What was promised, and how it is judged: a row of issue 4's table may be several goals."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Final, Literal

from e2e.lab.report import goal_measures, measures, pick
from e2e.lab.report.measure import Measure
from e2e.lab.report.recovery import can_tell
from e2e.lab.report.shown import Spread

if TYPE_CHECKING:
    from collections.abc import Iterator

    from e2e.lab.cell import Cell, SystemName
    from e2e.lab.report.blocks import Entry
    from e2e.lab.report.pick import Entries

PEERS: Final[tuple[SystemName, ...]] = ("stock", "livekit")
ALL: Final = {**measures.MEASURES, **goal_measures.MEASURES}
NEVER: Final = ("goal_fresh_after_ms", "goal_full_after_ms")
"""A missing number of these means that it was never reached."""
NO_DRIFT_MS: Final = 20.0
"""A minute: what the instrument does not tell from none in a cell of a minute."""
COST: Final = Measure(
    "goal_cost_share", "a further observer’s cost, of one core", "share", lambda _: None
)
CHANGED: Final = Measure(
    "goal_crowd_ms", "operator’s picture p95 with the crowd, more by", "ms", lambda _: None
)
Verdict = Literal["met", "missed", "not judged"]


@dataclass(frozen=True, slots=True)
class Goal:
    """`profile` and `system` are whose cells; judged is the median of `measure` over them.

    It is `at_most` or `at_least` that, and at most `of_peer` times the better peer's.
    """

    profile: str
    system: SystemName
    measure: Measure
    at_most: float | None = None
    at_least: float | None = None
    of_peer: float | None = None
    of_peer_words: str = ""
    kind: Literal["cells", "cost", "crowd"] = "cells"

    @property
    def words(self) -> str:
        """Write what is to be reached."""
        parts = []
        if self.at_most is not None:
            none = self.at_most == 0
            parts.append("none" if none else f"≤ {self.measure.with_unit(self.at_most)}")
        if self.at_least is not None:
            parts.append(f"≥ {self.measure.with_unit(self.at_least)}")
        if self.of_peer is not None:
            parts.append(self.of_peer_words)
        return " and ".join(parts)


@dataclass(frozen=True, slots=True)
class Judged:
    """`found` has what was measured, of each system that was; with it the cells behind it."""

    goal: Goal
    found: dict[SystemName, Spread]
    cells: dict[SystemName, Entries]
    verdict: Verdict


def judge(goal: Goal, cells: Entries) -> Judged:
    """Judge one; pure."""
    of_system = {system: _cells(goal, cells, system) for system in (goal.system, *PEERS)}
    found = {
        system: _spread(values)
        for system, entries in of_system.items()
        if (values := _values(goal, cells, entries))
    }
    return Judged(goal, found, of_system, _verdict(goal, found, of_system[goal.system]))


def goals(cells: Entries) -> Iterator[Goal]:
    """Give all of which there is a cell of ours, planned for this or not."""
    there = {(entry.cell.profile, entry.cell.system) for entry in cells}
    for goal in _all():
        if (goal.profile, goal.system) in there:
            yield goal


def observers(cells: Entries, system: SystemName) -> list[int]:
    """List how many observers the crowds had, the fewest first."""
    there = pick.where(cells, lambda cell: cell.system == system and _is_crowd(cell))
    return sorted({entry.cell.viewers - 1 for entry in there})


def _all() -> Iterator[Goal]:
    def goal(
        profile: str,
        system: SystemName,
        name: str,
        at_most: float | None = None,
        **more: object,
    ) -> Goal:
        return Goal(profile, system, ALL[name], at_most, **more)  # type: ignore[arg-type]  # Goal's own keywords

    here = "same-machine"
    yield goal(
        here, "operator", "picture_age_p50_ms", 20, of_peer=0.5, of_peer_words="≤ ½ of the better’s"
    )
    yield goal(here, "operator", "picture_age_p95_ms", 40)
    yield goal(here, "operator", "sound_age_p50_ms", 80)
    yield goal(here, "audio-master", "goal_skew_p95_ms", 20)
    yield goal(here, "audio-master", "sound_age_p50_ms", 90)
    yield goal("internet-5m", "audio-master", "goal_pauses", 0)
    yield goal("internet-5m", "audio-master", "sound_age_p50_ms", 160)
    yield goal("internet-5m", "audio-master", "goal_skew_p95_ms", 20)
    yield goal(
        "internet-5m",
        "operator",
        "picture_age_p95_ms",
        of_peer=0.7,
        of_peer_words="≤ 0.7 of the better’s",
    )
    both: tuple[SystemName, ...] = ("operator", "audio-master")
    for system in both:
        yield goal("wireless-1m", system, "goal_pictures_640_per_s", at_least=25)
        yield goal("wireless-1m", system, "picture_age_p95_ms", 150)
        yield goal("wireless-1m", system, "goal_pauses", 0)
    yield goal("modem-56k", "operator", "goal_concealed_share", 0.01)
    yield goal("modem-56k", "operator", "goal_pictures_160_per_s", at_least=5)
    yield goal("modem-56k", "operator", "picture_age_p95_ms", 600)
    yield goal("modem-56k", "operator", "goal_picture_drift_ms_per_min", NO_DRIFT_MS)
    yield goal("modem-56k", "operator", "goal_sound_drift_ms_per_min", NO_DRIFT_MS)
    yield goal("modem-56k", "operator", "command_round_trip_p95_ms", 300)
    yield goal("modem-56k", "operator", "goal_set_points_per_s", at_least=18)
    for system in both:
        yield goal("wifi-bad", system, "goal_concealed_share", 0.01)
        yield goal("wifi-bad", system, "longest_freeze_ms", 300)
    for system in both:
        yield goal("step-down", system, "goal_fresh_after_ms", 2000)
        yield goal("step-down", system, "goal_step_pause_ms", 300)
        yield goal("step-down", system, "goal_full_after_ms", 15_000)
    yield goal("satellite", "audio-master", "goal_breaks", 0)
    yield goal("satellite", "audio-master", "goal_skew_p95_ms", 20)
    yield Goal(
        here,
        "operator",
        COST,
        of_peer=1 / 25,
        of_peer_words="≤ 1/25 of stock’s",
        kind="cost",
    )
    yield Goal(here, "operator", CHANGED, 5, kind="crowd")


def _cells(goal: Goal, cells: Entries, system: SystemName) -> Entries:
    on = pick.where(
        pick.on(cells, goal.profile, system),
        lambda cell: (cell.browser, cell.content) == ("chromium", "testcard"),
    )
    if goal.kind != "cells":
        return pick.where(on, _is_crowd)
    drives = goal.profile == "modem-56k" and system == "operator"
    return pick.where(on, lambda cell: cell.viewers == 1 and cell.drives == drives)


def _is_crowd(cell: Cell) -> bool:
    return cell.viewers > 1


def _values(goal: Goal, cells: Entries, entries: Entries) -> list[float]:
    match goal.kind:
        case "cells":
            values = (_value(goal, entry) for entry in entries)
            return [value for value in values if value is not None]
        case "cost":
            return _costs(entries)
        case "crowd":
            alone = pick.where(
                pick.on(cells, goal.profile),
                lambda cell: (
                    (cell.viewers, cell.drives) == (1, False)
                    and cell.system in {entry.cell.system for entry in entries}
                ),
            )
            return _changes(entries, alone)


def _value(goal: Goal, entry: Entry) -> float | None:
    """Give the number; infinity for what was looked for and never reached."""
    value = goal.measure.of(entry.result)
    never = goal.measure.name in NEVER and can_tell(entry.result, "picture")
    return math.inf if value is None and never else value


def _costs(entries: Entries) -> list[float]:
    """Of each repetition: by how much the larger crowd costs more than the smaller, for each."""
    cpu = ALL["server_cpu_share"]
    costs = []
    for here in _by_repeat(entries).values():
        by_number = {
            entry.cell.viewers: value
            for entry in here
            if (value := cpu.of(entry.result)) is not None
        }
        few, many = min(by_number, default=0), max(by_number, default=0)
        if few < many:
            costs.append((by_number[many] - by_number[few]) / (many - few))
    return costs


def _changes(entries: Entries, alone: Entries) -> list[float]:
    """Of each repetition: the largest crowd's picture p95 less that without anybody."""
    age = ALL["picture_age_p95_ms"]
    without = _by_repeat(alone)
    changes = []
    for repeat, here in _by_repeat(entries).items():
        most = max(here, key=lambda entry: entry.cell.viewers)
        value = age.of(most.result)
        before = [
            one for entry in without.get(repeat, ()) if (one := age.of(entry.result)) is not None
        ]
        if value is not None and before:
            changes.append(value - median(before))
    return changes


def _by_repeat(entries: Entries) -> dict[int, Entries]:
    found: dict[int, Entries] = defaultdict(tuple)
    for entry in entries:
        found[entry.cell.repeat] += (entry,)
    return found


def _spread(values: list[float]) -> Spread:
    return Spread(median(values), min(values), max(values), len(values))


def _verdict(goal: Goal, found: dict[SystemName, Spread], entries: Entries) -> Verdict:
    ours = found.get(goal.system)
    if ours is None:
        # Where no picture came, or all failed, nothing was reached; where nothing was asked, or
        # this machine has not what it takes, nothing is known.
        failed = any(entry.result.status == "failed" for entry in entries)
        return "missed" if failed else "not judged"
    reached = [
        goal.at_most is None or ours.median <= goal.at_most,
        goal.at_least is None or ours.median >= goal.at_least,
    ]
    if goal.of_peer is not None:
        peers = [found[system].median for system in PEERS if system in found]
        if not peers:
            return "not judged"
        reached.append(ours.median <= goal.of_peer * min(peers))
    return "met" if all(reached) else "missed"
