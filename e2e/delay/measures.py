"""Every number of a cell: its name, its unit, how a person writes it, and where it comes from."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

from e2e.delay import series
from e2e.delay.names import changes_s
from e2e.instrument.pauses import concealed_pauses, tone_pauses
from e2e.instrument.quantities import summed
from e2e.instrument.sums import share

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.delay.figures import Figures, Pauses
    from e2e.delay.readings import Readings
    from e2e.delay.results import CellResult

    Get = Callable[[CellResult], float | None]
    FromReadings = Callable[[Readings, Figures], float | None]

Unit = Literal["ms", "±ms", "/s", "/min", "s", "%", "kB/s", "±ms/min", "MiB", ""]

BRIDGED_MS: Final = 50.0
"""What 2004's client bridged: a delay of 38 ms was not heard, since that is less (5.2.1.3)."""
LATE_MS: Final = 100.0
"""One video MU: a picture this much older than the cell's youngest is late (after 5.2.1.1)."""
JOINED_MS: Final = 3000.0
"""So long after the first picture the goal's skew counts."""
ENDED_MS: Final = 5000.0
"""Without a picture for this long at the end of a cell, nobody is connected."""


@dataclass(frozen=True, slots=True)
class Measure:
    """`get` gives None where there is nothing measured; shares and bytes come as `unit` has them.

    With `may_never` a missing number means, where the link changed, that it was never reached.
    """

    name: str
    label: str
    unit: Unit
    get: Get
    about: str = ""
    may_never: bool = False

    def of(self, result: CellResult) -> float | None:
        value = self.get(result)
        return value if value is not None and math.isfinite(value) else None

    def text(self, value: float) -> str:
        """Write it without its unit: three figures, a true minus, a plus where the sign tells."""
        size = abs(value)
        digits = 0 if size >= 100 or ("ms" in self.unit and size >= 10) else 1
        digits = 2 if 0 < size < 1 else digits
        text = f"{value:{'+' if self.unit.startswith('±') else ''}.{digits}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
        return "0" if text.strip("+-0.") == "" else text.replace("-", "−")

    def with_unit(self, value: float) -> str:
        return f"{self.text(value)} {self.unit.lstrip('±')}".rstrip()


def hears_tone(result: CellResult) -> bool:
    """Whether gaps of the tone could be found: speech has no tone."""
    return result.cell.content == "testcard" and bool(result.readings.sound.start_ms)


def _at(path: str, scale: float = 1.0) -> Get:
    """Follow attributes from a result; None where one of them is."""

    def get(result: CellResult) -> float | None:
        value: Any = result
        for name in path.split("."):
            value = getattr(value, name, None)
        return scale * value if isinstance(value, float | int) else None

    return get


def _told(name: str, scale: float = 1.0) -> Get:
    def get(result: CellResult) -> float | None:
        value = result.told.get(name)
        return scale * value if isinstance(value, float | int) else None

    return get


def _read(get: FromReadings) -> Get:
    return lambda result: get(result.readings, result.figures)


def _bytes_per_s(kind: str) -> Get:
    return _at(f"figures.{kind}_bytes_per_s", 0.001)


def _pauses(
    kind: Literal["tone", "concealed"], sum_up: Callable[[list[float], float], float]
) -> Get:
    """Sum up the lengths of the pauses, ms, over the minutes of sound that were judged."""

    def get(result: CellResult) -> float | None:
        figures = result.figures
        # WAX's own player counts what it made up, not in how many pieces.
        is_counted = figures.concealed_share is not None and not result.readings.own_sound.at_ms
        told = hears_tone(result) if kind == "tone" else is_counted
        minutes = (figures.to_ms - figures.sound_from_ms) / 60_000
        if not told or not minutes > 0:
            return None
        pauses: Pauses = getattr(figures, f"{kind}_pauses")
        return sum_up(pauses.length_ms, minutes)

    return get


def _per_min(lengths_ms: list[float], minutes: float) -> float:
    return len(lengths_ms) / minutes


def _longest(lengths_ms: list[float], minutes: float) -> float:
    return max(lengths_ms, default=0.0)


def _percent(lengths_ms: list[float], minutes: float) -> float:
    return sum(lengths_ms) / (600 * minutes)


def _late_pictures_per_s(readings: Readings, figures: Figures) -> float | None:
    ages = [
        age_ms
        for at_ms, age_ms in series.picture_ages(readings)
        if figures.from_ms <= at_ms <= figures.to_ms
    ]
    seconds = (figures.to_ms - figures.from_ms) / 1000.0
    if not ages or not seconds > 0:
        return None
    return sum(age_ms > min(ages) + LATE_MS for age_ms in ages) / seconds


def skew_p95_ms(readings: Readings, figures: Figures) -> float | None:
    """p95 of the absolute skew from 3 s after joining on, joining being the first picture.

    Sound that comes later than that has no skew before; the figure of the first sound tells of it.
    """
    if readings.first_picture_ms is None:
        return None
    from_ms = readings.first_picture_ms + JOINED_MS
    found = summed(
        [abs(skew) for at_ms, skew in series.skews(readings) if from_ms <= at_ms <= figures.to_ms]
    )
    return found.p95 if found else None


def _share_percent(what: Literal["concealed", "stretched"]) -> FromReadings:
    """Of the samples that were played from the first sound on, those that were so."""

    def get(readings: Readings, figures: Figures) -> float | None:
        if readings.first_sound_ms is None:
            return None
        found = share(readings, what, readings.first_sound_ms, figures.to_ms)
        return None if found is None else 100 * found

    return get


def _heard_and_counted(
    readings: Readings, from_ms: float, to_ms: float
) -> tuple[list[float], list[float]]:
    """Lengths of the gaps in the tone as heard, and of the concealments as counted, ms."""
    return (
        tone_pauses(readings.sound, from_ms, to_ms).length_ms,
        concealed_pauses(readings.counters, from_ms, to_ms).length_ms,
    )


def pauses(readings: Readings, figures: Figures) -> float | None:
    """How often the sound paused since it was first heard, as heard or as counted."""
    if readings.first_sound_ms is None:
        return None
    both = _heard_and_counted(readings, readings.first_sound_ms, figures.to_ms)
    return float(max(map(len, both)))


def _rate(least: tuple[int, int]) -> FromReadings:
    def rate(readings: Readings, figures: Figures) -> float | None:
        if figures.to_ms <= figures.from_ms or not readings.pictures.at_ms:
            return None
        shown = [
            large
            for at_ms, large in series.sized(readings, least)
            if figures.from_ms <= at_ms <= figures.to_ms
        ]
        return 1000 * sum(shown) / (figures.to_ms - figures.from_ms)

    return rate


def breaks(readings: Readings, figures: Figures) -> float | None:
    """How often the page's connection changed its state after it was connected; 0 is never.

    An end at which no picture comes any more counts as one. None where it was not looked at.
    """
    states = readings.connections.state
    if "connected" not in states:
        return None
    changes = len(states) - 1 - states.index("connected")
    shown = readings.pictures.at_ms
    is_over = not shown or figures.to_ms - shown[-1] > ENDED_MS
    return float(changes + is_over)


def set_points_per_s(readings: Readings, figures: Figures) -> float | None:
    """How often the page handed a set-point to its channel; None where it never did."""
    sent = readings.set_points.at_ms
    if not sent or figures.to_ms <= figures.from_ms:
        return None
    inside = sum(figures.from_ms <= at_ms <= figures.to_ms for at_ms in sent)
    return 1000 * inside / (figures.to_ms - figures.from_ms)


def step_ms(result: CellResult, which: int) -> float | None:
    """When the link changed, Unix ms: 0 for the first time, −1 for the last; None if it did not."""
    began_ms, changes = result.told.get("changes_began_ms"), changes_s(result.cell.profile)
    if not isinstance(began_ms, float | int) or not changes:
        return None
    return began_ms + 1000 * changes[which][0]


def _recovered(of: Literal["picture", "sound"], which: int) -> Get:
    def get(result: CellResult) -> float | None:
        first_ms, at_ms = step_ms(result, 0), step_ms(result, which)
        changes = changes_s(result.cell.profile)
        if first_ms is None or at_ms is None or (which == 0 and len(changes) < 2):
            return None
        next_ms = first_ms + 1000 * (changes[1][0] - changes[0][0]) if which == 0 else math.inf
        if of == "picture":
            ages = series.standing(series.picture_ages(result.readings))
        else:
            ages = series.sound_ages(result.readings)
        return series.recovery_ms(ages, first_ms, at_ms, next_ms)

    return get


def _from_step(get: Callable[[Readings, float, float, float], float | None]) -> Get:
    """Give `get` when the link was made worse, when it was whole again, and the cell's end."""

    def found(result: CellResult) -> float | None:
        worse_ms, whole_ms = step_ms(result, 0), step_ms(result, -1)
        if worse_ms is None or whole_ms is None or worse_ms == whole_ms:
            return None
        return get(result.readings, worse_ms, whole_ms, result.figures.to_ms)

    return found


_FULL: Final = (640, 480)
_SMALLEST: Final = (160, 120)
_AT: Final[tuple[tuple[str, str, Unit, str, str], ...]] = (
    ("picture_age_p50_ms", "picture, p50", "ms", "picture_age_ms.median", "capture to compositor"),
    ("picture_age_p95_ms", "picture, p95", "ms", "picture_age_ms.p95", ""),
    ("sound_age_p50_ms", "sound, p50", "ms", "sound_age_ms.median", "from capture to the ear"),
    ("sound_age_p95_ms", "sound, p95", "ms", "sound_age_ms.p95", ""),
    ("skew_p50_ms", "skew, p50", "±ms", "skew_ms.median", "sound’s age less picture’s"),
    ("absolute_skew_p95_ms", "|skew|, p95", "ms", "absolute_skew_p95_ms", ""),
    ("pictures_per_s", "pictures", "/s", "pictures_per_s", ""),
    ("longest_freeze_ms", "longest freeze", "ms", "longest_freeze_ms", ""),
    ("first_picture_ms", "first picture", "ms", "first_picture_ms", "since the navigation began"),
    ("command_round_trip_p50_ms", "command, p50", "ms", "command_round_trip_ms.median", "WAX only"),
    ("command_round_trip_p95_ms", "command, p95", "ms", "command_round_trip_ms.p95", ""),
    ("picture_drift_ms_per_min", "picture drift", "±ms/min", "picture_drift_ms_per_min", ""),
    ("sound_drift_ms_per_min", "sound drift", "±ms/min", "sound_drift_ms_per_min", ""),
    ("lip_lag_ms", "lip lag", "±ms", "lip_lag_ms", "how long the voice comes after the lips"),
    ("lip_correlation", "lip correlation", "", "lip_correlation", ""),
    ("speech_quality", "speech, MOS-LQO", "", "speech_quality", "ViSQOL, 1 to 5"),
)
"""What is a figure of the cell as it stands: name, label, unit, where in the figures, about."""
_TOLD: Final[tuple[tuple[str, str, Unit, str, float, str], ...]] = (
    ("fail_safe_s", "fail-safe mode", "s", "viewer.streams.fail_safe_s", 1, "thesis 3.3 and 3.5"),
    ("crowd_mean", "crowd, mean", "/s", "crowd.pictures_per_s_mean", 1, "pictures of the others"),
    ("crowd_least", "crowd, least", "/s", "crowd.pictures_per_s_min", 1, ""),
    ("crowd_lost", "crowd, lost", "%", "crowd.lost_share", 100, "of the packets to the others"),
    ("machine_busy", "the whole machine", "%", "machine.busy_share", 100, "busy"),
)
"""What the system or the lab tells beside: name, label, unit, its key, factor, about."""
_ALL: Final = (
    *(
        Measure(name, label, unit, _at(f"figures.{path}"), about)
        for name, label, unit, path, about in _AT
    ),
    *(
        Measure(name, label, unit, _told(key, factor), about)
        for name, label, unit, key, factor, about in _TOLD
    ),
    *(
        Measure(f"{kind}_kb_per_s", kind.replace("_", ", "), "kB/s", _bytes_per_s(kind))
        for kind in ("received", "received_audio", "received_video", "sent")
    ),
    Measure("server_cpu", "server CPU", "%", _at("server.cpu_share", 100), "of one core"),
    Measure("browser_cpu", "browser CPU", "%", _at("browser_cpu_share", 100), "of one core"),
    Measure("server_memory_mib", "server memory", "MiB", _at("server.memory_mib")),
    Measure(
        "late_pictures_per_s",
        "late pictures",
        "/s",
        _read(_late_pictures_per_s),
        f"older than the cell’s youngest by more than {LATE_MS:.0f} ms",
    ),
    Measure(
        "tone_pauses_per_min",
        "tone gaps",
        "/min",
        _pauses("tone", _per_min),
        "gaps of 30 ms or more in the tone as it was played",
    ),
    Measure(
        "heard_tone_pauses_per_min",
        f"tone gaps above {BRIDGED_MS:.0f} ms",
        "/min",
        _pauses("tone", lambda ms, minutes: sum(one > BRIDGED_MS for one in ms) / minutes),
        "as long as those that the thesis calls pauses",
    ),
    Measure("longest_tone_pause_ms", "longest tone gap", "ms", _pauses("tone", _longest)),
    Measure("tone_pause_share", "tone gaps, of the time", "%", _pauses("tone", _percent)),
    Measure(
        "concealed_pauses_per_min",
        "concealments",
        "/min",
        _pauses("concealed", _per_min),
        "100 ms or more of sound made up without a break, by the browser’s counts",
    ),
    Measure(
        "longest_concealed_pause_ms", "longest concealment", "ms", _pauses("concealed", _longest)
    ),
    *(
        Measure(
            f"{of}_{done}_ms",
            f"{of} after the {change} change",
            "ms",
            _recovered(of, which),
            may_never=which == -1,
        )
        for of in ("picture", "sound")
        for done, change, which in (("adapted", "first", 0), ("recovered", "last", -1))
    ),
    Measure(
        "joined_skew_p95_ms",
        "|skew|, p95, from 3 s after joining",
        "ms",
        _read(skew_p95_ms),
        "of each second’s burst; joining is the first picture",
    ),
    Measure("concealed_percent", "concealed sound", "%", _read(_share_percent("concealed"))),
    Measure("stretched_percent", "stretched sound", "%", _read(_share_percent("stretched"))),
    Measure(
        "pauses",
        "audible pauses",
        "",
        _read(pauses),
        "as heard or as the browser counts, whichever are more, from the first sound on",
    ),
    Measure("pictures_640_per_s", "pictures at 640×480", "/s", _read(_rate(_FULL))),
    Measure("pictures_160_per_s", "pictures at 160×120 or more", "/s", _read(_rate(_SMALLEST))),
    Measure("breaks", "breaks of the connection", "", _read(breaks)),
    Measure("set_points_per_s", "set-points sent", "/s", _read(set_points_per_s)),
    Measure(
        "fresh_after_ms",
        f"picture under {series.FRESH_MS:.0f} ms again",
        "ms",
        _from_step(
            lambda read, worse_ms, _, to_ms: series.fresh_after_ms(
                series.picture_ages(read), worse_ms, to_ms
            )
        ),
        "from when the link was made worse",
        may_never=True,
    ),
    Measure(
        "step_pause_ms",
        "longest pause after the step",
        "ms",
        _from_step(
            lambda read, worse_ms, _, to_ms: max(
                [0.0, *itertools.chain(*_heard_and_counted(read, worse_ms, to_ms))]
            )
        ),
    ),
    Measure(
        "full_after_ms",
        "full quality after recovery",
        "ms",
        _from_step(
            lambda read, _, whole_ms, __: series.full_after_ms(series.sized(read, _FULL), whole_ms)
        ),
        "640×480 at 27 or more pictures in each second, from when the link was whole again",
        may_never=True,
    ),
)
MEASURES: Final[dict[str, Measure]] = {measure.name: measure for measure in _ALL}


def measured(result: CellResult) -> dict[str, float | None]:
    """Take every number that there is; None where it was looked for and never reached."""
    found: dict[str, float | None] = {}
    for measure in _ALL:
        value = measure.of(result)
        never = measure.may_never and value is None and step_ms(result, -1) is not None
        if value is not None or never:
            found[measure.name] = value
    return found
