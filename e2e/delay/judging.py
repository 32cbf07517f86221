"""The goals, and how they are judged: medians over the repetitions, compared with the peers'."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

from e2e.delay.cell import GOALS, Cell
from e2e.delay.measures import MEASURES
from e2e.delay.names import PEERS, SYSTEMS, SystemName, shown
from e2e.measure.row import Row, summarize
from e2e.peers.sizes import SIZES, VGA, SizeName

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence


OURS: Final = "WAX"
BROWSERS: Final = "browser’s player"
_OPERATOR: Final[SystemName] = "operator"
_OBSERVER: Final[SystemName] = "audio-master"
_WHO: Final[dict[SystemName, str]] = {"operator": "who drives", "audio-master": "an observer"}
_SYSTEMS: Final[tuple[SystemName, ...]] = ("thesis", "stock", "livekit", "livekit-whip")
COLUMNS: Final = (OURS, BROWSERS, *(SYSTEMS[system] for system in _SYSTEMS))


class Found(NamedTuple):
    """One cell with its figures by name; None means measured but never reached."""

    cell: Cell
    values: Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal for the median of `measure` over the cells of `profile` and `system`.

    It must be `at_most` or `at_least` this number, and at most `times` the least, or at least
    `times` the greatest, of the columns `of`, plus `plus`. A figure with a sign, such as a drift,
    is judged by its size. For a ``crowd`` the figure is the increase over the cells with one
    viewer.
    """

    profile: str
    system: SystemName
    measure: str
    at_most: float | None = None
    at_least: float | None = None
    times: float = 1.0
    plus: float = 0.0
    of: tuple[str, ...] = ()
    size: SizeName = "640x480"
    experiment: str = GOALS
    kind: Literal["cells", "crowd"] = "cells"

    @property
    def key(self) -> str:
        prefix = "" if self.experiment == GOALS else f"{self.experiment}/"
        place = f"{prefix}{shown(self.profile)}"
        place += "" if SIZES[self.size] is VGA else f"/{self.size}"
        return f"{place}/{self.system}/{self.measure}/{self.kind}"


def goals(drives: Iterable[str] = ()) -> Iterator[Goal]:
    """Yield the goals, the long ones last; `drives` are recorded drives over cellular links."""
    here, drives_it, observes = "same-machine", _OPERATOR, _OBSERVER
    picture, sound, skew = "picture_age_p95_ms", "sound_age_p50_ms", "joined_skew_p95_ms"
    peers: Any = {"of": (SYSTEMS["stock"], SYSTEMS["livekit-whip"])}
    browsers: Any = {"of": (BROWSERS,)}
    stock: Any = {"of": (SYSTEMS["stock"],)}
    sharp: Any = {"at_least": 0.0, "of": tuple(SYSTEMS[peer] for peer in PEERS)}
    asked: tuple[tuple[Any, ...], ...] = (
        (here, drives_it, "picture_age_p50_ms", 20, {"times": 0.5, **peers}),
        (here, drives_it, picture, 40, {}),
        (here, drives_it, "sharpness_ssim", None, sharp),
        (here, drives_it, sound, 50, {"times": 0.6, **peers}),
        (here, observes, sound, 62, {}),
        (here, observes, skew, 20, {}),
        (here, drives_it, "browser_cpu", None, {"plus": 5.0, **browsers}),
        (here, drives_it, picture, 5, {"kind": "crowd"}),
        ("internet-5m", drives_it, picture, None, {"times": 0.85, **peers}),
        ("internet-5m", drives_it, "sharpness_ssim", None, sharp),
        ("internet-5m", observes, skew, 20, {}),
        ("internet-5m", observes, "pauses", 0, {}),
        ("wireless-1m", drives_it, "pictures_640_per_s", None, {"at_least": 25}),
        ("wireless-1m", drives_it, picture, 150, {}),
        ("wireless-1m", drives_it, "sharpness_ssim", None, sharp),
        ("wireless-1m", observes, skew, 20, {}),
        ("modem-56k", drives_it, "concealed_percent", 1.0, {}),
        ("modem-56k", drives_it, sound, None, {"times": 0.8, **browsers}),
        ("modem-56k", drives_it, picture, 600, {}),
        ("modem-56k", drives_it, "sharpness_ssim", None, sharp),
        ("modem-56k", drives_it, "command_round_trip_p95_ms", 300, {}),
        ("modem-56k", drives_it, "pictures_160_per_s", None, {"at_least": 5}),
        ("wifi-bad", drives_it, "longest_freeze_ms", 300, {}),
        ("wifi-bad", drives_it, "sharpness_ssim", None, sharp),
        ("wifi-bad", observes, "concealed_percent", 0.5, {}),
        ("wifi-bad", observes, sound, None, {"times": 0.8, **browsers}),
        ("wifi-bad", observes, skew, 20, {}),
        ("cafe", drives_it, sound, 100, {}),
        ("cafe", drives_it, "sharpness_ssim", None, sharp),
        ("cafe", observes, skew, 20, {}),
        ("stalls", observes, sound, 180, {}),
        ("stalls", observes, "concealed_percent", 0.5, {}),
        ("stalls", observes, "stretched_percent", 0.5, {}),
        ("stalls", observes, skew, 20, {}),
        ("satellite", observes, "breaks", 0, {}),
        ("satellite", observes, skew, 20, {}),
        ("step-down", drives_it, "fresh_after_ms", 2000, {}),
        ("step-down", drives_it, "step_pause_ms", 300, {}),
        ("step-down", drives_it, "full_after_ms", 15_000, {}),
        ("outage", drives_it, "picture_recovered_ms", 500, {}),
        ("outage", drives_it, "full_after_ms", 3000, {}),
    )
    large: tuple[tuple[Any, ...], ...] = (
        (here, "picture_age_p50_ms", None, {"times": 0.9, **peers}),
        (here, picture, None, {"times": 0.6, **stock}),
        (here, "arrival_age_p50_ms", 18, {}),
        (here, "arrival_age_p95_ms", 28, {}),
        (here, "pictures_1280_per_s", None, {"at_least": 29}),
        (here, "sharpness_ssim", None, sharp),
        (here, "server_cpu", 50, {}),
        ("internet-5m", picture, None, {"times": 0.85, **peers}),
        ("internet-5m", "sharpness_ssim", None, sharp),
    )
    asked += tuple(
        (profile, drives_it, measure, at_most, {"size": "1280x720", **more})
        for profile, measure, at_most, more in large
    )
    film: Any = {"size": "1280x720-film", **sharp}
    asked += tuple(
        (profile, drives_it, "sharpness_ssim", None, film)
        for profile in ("internet-5m", "wireless-1m")
    )
    for profile, system, measure, at_most, more in asked:
        yield Goal(profile, system, measure, at_most, **more)
    for profile in ("wireless-2m", "lte-good"):
        yield Goal(profile, observes, skew, 20, experiment="matrix")
    yield Goal("outage", observes, "picture_recovered_ms", 500, experiment="matrix")
    for measure, limit in (("picture_drift_ms_per_min", 20), ("sound_drift_ms_per_min", 20)):
        yield Goal("modem-56k", drives_it, measure, limit, experiment="steady")
    yield Goal("modem-56k", drives_it, "set_points_per_s", at_least=18, experiment="steady")
    yield Goal(here, observes, "sound_drift_ms_per_min", 5 / 30, experiment="steady")
    yield Goal("satellite", observes, "breaks", 0, experiment="steady")
    for drive in drives:
        there: Any = {"experiment": "drive", **stock}
        yield Goal(drive, observes, sound, **there)
        yield Goal(drive, observes, "concealed_percent", times=0.5, **there)
        yield Goal(drive, drives_it, sound, times=0.7, **there)
        yield Goal(drive, drives_it, picture, times=0.5, **there)


def found(rows: Iterable[Row]) -> list[Found]:
    """Return the cells among a suite's rows; rows of other cases are left out."""
    return [
        Found(Cell.model_validate(row.detail["cell"]), row.values)
        for row in rows
        if "cell" in row.detail
    ]


def judged(rows: Sequence[Row]) -> list[Row]:
    """Judge every goal for which there is a cell of ours; recorded drives by their names."""
    cells = found(rows)
    drives = sorted({one.cell.profile for one in cells if one.cell.experiment == "drive"})
    return [judge(goal, cells) for goal in goals(drives) if _cells(goal, cells, OURS)]


def judge(goal: Goal, cells: Sequence[Found]) -> Row:
    """Judge one goal. A figure that never came, or came without a picture, has missed it."""
    values = {column: _value(goal, cells, column) for column in COLUMNS}
    value = values[OURS]
    is_floor = goal.at_least is not None
    limit = goal.at_least if is_floor else goal.at_most
    met: bool | None = value is not None
    if goal.of:
        known = [one for name in goal.of if (one := values[name]) is not None]
        hardest = max if is_floor else min
        beside = [goal.times * hardest(known) + goal.plus] if known else []
        limit = hardest((one for one in (limit, *beside) if one is not None), default=None)
        met = met if known or value is None else None
    if met and value is not None and limit is not None:
        met = value >= limit if is_floor else value <= limit
    here = _cells(goal, cells, OURS)
    numbers = _numbers(goal, cells, OURS)
    return Row(
        key=goal.key,
        what=_what(goal),
        n=len(here),
        unit=MEASURES[goal.measure][1],
        values=values,
        spread=summarize(numbers) if numbers else None,
        judged=OURS,
        goal=limit,
        at_least=is_floor,
        met=met,
        load=_load(goal, here),
    )


def _what(goal: Goal) -> str:
    where = f"{shown(goal.profile)}{SIZES[goal.size].label}"
    what = f"{where}, {_WHO[goal.system]}: {MEASURES[goal.measure][0]}"
    if goal.kind == "crowd":
        what += ", added by the crowd"
    if not goal.of:
        return what
    names = (f"{goal.of[0]}’s", "the better peer’s", "the best peer’s")
    whose = names[min(len(goal.of), 3) - 1]
    sign = "≤" if goal.at_least is None else "≥"
    factor = "" if goal.times == 1 else f"{goal.times:.3g} × "
    more = f" + {goal.plus:g}" if goal.plus else ""
    return f"{what} ({sign} {factor}{whose}{more})"


def _cells(goal: Goal, cells: Sequence[Found], column: str) -> list[Found]:
    """Return the cells of a column: a peer's system, or WAX as seen by the goal's viewer."""

    def has(cell: Cell) -> bool:
        if column in (OURS, BROWSERS):
            player = "browser" if column == BROWSERS else "auto"
            return (cell.system, cell.player) == (goal.system, player)
        return SYSTEMS[cell.system] == column

    return [
        one
        for one in cells
        if one.cell.profile == goal.profile
        and (one.cell.size, one.cell.experiment) == (goal.size, goal.experiment)
        and (one.cell.viewers > 1) == (goal.kind == "crowd")
        and has(one.cell)
    ]


def _value(goal: Goal, cells: Sequence[Found], column: str) -> float | None:
    """Return the median; None if most of the cells measured it and never reached it."""
    tried = [one.values for one in _cells(goal, cells, column) if goal.measure in one.values]
    if 2 * sum(values[goal.measure] is None for values in tried) > len(tried):
        return None
    numbers = _numbers(goal, cells, column)
    return summarize(numbers).median if numbers else None


def _numbers(goal: Goal, cells: Sequence[Found], column: str) -> list[float]:
    """Return one number for each repetition."""
    here = _cells(goal, cells, column)
    numbers = [abs(value) for one in here if (value := one.values.get(goal.measure)) is not None]
    if goal.kind == "cells":
        return numbers
    alone_goal = Goal(goal.profile, goal.system, goal.measure)
    alone = _value(alone_goal, cells, column)
    return [] if alone is None else [number - alone for number in numbers]


def _load(goal: Goal, ours: Sequence[Found]) -> str:
    """Say how long was measured and, for a crowd, how large it was and how busy the machine."""
    cell = ours[0].cell
    if goal.kind == "cells":
        return f"{cell.seconds:g} s"
    busy = [value for one in ours if (value := one.values.get("machine_busy")) is not None]
    told = f", {summarize(busy).median:.0f} % of the whole machine busy" if busy else ""
    return f"{cell.viewers - 1} observers, {cell.slow} behind a modem, {cell.seconds:g} s{told}"
