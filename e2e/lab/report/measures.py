"""Every figure of a cell, each as one number."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from e2e.lab.report import series
from e2e.lab.report.measure import Measure, from_readings

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.lab.figures import Figures, Kinds, Pauses, Quantiles
    from e2e.lab.results import CellResult


def hears_tone(result: CellResult) -> bool:
    """Whether gaps of the tone could be found: the face speaks, it has no tone."""
    if result.figures is None or result.cell.content != "testcard":
        return False
    if result.readings is not None and result.readings.sound.start_ms:
        return True
    return result.figures.sound_age_ms is not None


def counts_concealment(result: CellResult) -> bool:
    return result.figures is not None and result.figures.concealed_share is not None


def heard_min(figures: Figures) -> float:
    """How many minutes of sound were judged; 0 or less where it came too late for that."""
    from_ms = figures.from_ms if figures.sound_from_ms is None else figures.sound_from_ms
    return (figures.to_ms - from_ms) / 60_000.0


def _figures(get: Callable[[Figures], float | None]) -> Callable[[CellResult], float | None]:
    return lambda result: None if result.figures is None else get(result.figures)


def _quantile(
    name: str, part: Literal["p50", "p95", "max"]
) -> Callable[[CellResult], float | None]:
    def get(figures: Figures) -> float | None:
        quantiles: Quantiles | None = getattr(figures, name)
        return None if quantiles is None else float(getattr(quantiles, part))

    return _figures(get)


def _plain(name: str) -> Callable[[CellResult], float | None]:
    return _figures(lambda figures: getattr(figures, name))


def _pauses(
    kind: Literal["tone", "concealed"],
    what: Literal["count", "longest", "share"],
    above_ms: float = 0.0,
) -> Callable[[CellResult], float | None]:
    is_told = hears_tone if kind == "tone" else counts_concealment

    def get(result: CellResult) -> float | None:
        figures = result.figures
        if figures is None or not is_told(result):
            return None
        pauses: Pauses = getattr(figures, f"{kind}_pauses")
        minutes = heard_min(figures)
        if not minutes > 0:
            return None
        if what == "longest":
            return max(pauses.length_ms, default=0.0)
        if what == "share":
            return sum(pauses.length_ms) / (60_000.0 * minutes)
        return sum(length_ms > above_ms for length_ms in pauses.length_ms) / minutes

    return get


def _bytes(way: Literal["received", "sent"], kind: str) -> Callable[[CellResult], float | None]:
    def get(figures: Figures) -> float | None:
        kinds: Kinds = getattr(figures, f"{way}_bytes_per_s")
        if kind != "total":
            value: float | None = getattr(kinds, kind)
            return value
        known = [value for _, value in kinds if value is not None]
        return sum(known) if known else None

    return _figures(get)


def _told(name: str) -> Callable[[CellResult], float | None]:
    def get(result: CellResult) -> float | None:
        value = result.told.get(name)
        return float(value) if isinstance(value, float | int) else None

    return get


HEARD_MS: Final = 50.0
"""What 2004's client bridged: a delay of 38 ms was not heard, since that is less (5.2.1.3)."""
KINDS: Final = ("audio", "video", "repeated", "data", "other")
_AGE = "from capture to the screen"
_ALL: Final = (
    Measure("picture_age_p50_ms", "picture, p50", "ms", _quantile("picture_age_ms", "p50"), _AGE),
    Measure("picture_age_p95_ms", "picture, p95", "ms", _quantile("picture_age_ms", "p95"), _AGE),
    Measure(
        "sound_age_p50_ms",
        "sound, p50",
        "ms",
        _quantile("sound_age_ms", "p50"),
        "from capture to the ear",
    ),
    Measure("sound_age_p95_ms", "sound, p95", "ms", _quantile("sound_age_ms", "p95")),
    Measure(
        "skew_p50_ms",
        "skew, p50",
        "signed ms",
        _quantile("skew_ms", "p50"),
        "sound’s age less picture’s: above 0 the sound comes after the picture",
    ),
    Measure("absolute_skew_p95_ms", "|skew|, p95", "ms", _plain("absolute_skew_p95_ms")),
    Measure("pictures_per_s", "pictures", "per s", _plain("pictures_per_s")),
    Measure("longest_freeze_ms", "longest freeze", "ms", _plain("longest_freeze_ms")),
    Measure(
        "late_pictures_per_s",
        "late pictures",
        "per s",
        from_readings(series.late_pictures_per_s),
        f"older than the cell’s youngest by more than {series.LATE_MS:.0f} ms",
    ),
    Measure(
        "picture_stalls_per_s",
        "picture stalls",
        "per s",
        from_readings(series.picture_stalls_per_s),
        f"one picture stood for {series.STALL_MS:.0f} ms or longer",
    ),
    Measure(
        "tone_pauses_per_min",
        "tone gaps",
        "per min",
        _pauses("tone", "count"),
        "gaps of 30 ms or more in the tone as it was played",
    ),
    Measure(
        "heard_tone_pauses_per_min",
        f"tone gaps above {HEARD_MS:.0f} ms",
        "per min",
        _pauses("tone", "count", HEARD_MS),
        "as long as those that the thesis calls pauses",
    ),
    Measure("longest_tone_pause_ms", "longest tone gap", "ms", _pauses("tone", "longest")),
    Measure("tone_pause_share", "tone gaps, of the time", "share", _pauses("tone", "share")),
    Measure(
        "concealed_pauses_per_min",
        "concealments",
        "per min",
        _pauses("concealed", "count"),
        "100 ms or more of sound made up without a break, by the browser’s counts",
    ),
    Measure(
        "longest_concealed_pause_ms", "longest concealment", "ms", _pauses("concealed", "longest")
    ),
    Measure(
        "concealed_pause_share",
        "concealments, of the time",
        "share",
        _pauses("concealed", "share"),
    ),
    Measure("concealed_share", "concealed", "share", _plain("concealed_share")),
    Measure(
        "first_picture_ms",
        "first picture",
        "ms",
        _plain("first_picture_ms"),
        "from the begin of the navigation",
    ),
    Measure("first_sound_ms", "first sound", "ms", _plain("first_sound_ms")),
    Measure(
        "command_round_trip_p50_ms",
        "command, p50",
        "ms",
        _quantile("command_round_trip_ms", "p50"),
        "round trip over the data channel, WAX only",
    ),
    Measure(
        "command_round_trip_p95_ms",
        "command, p95",
        "ms",
        _quantile("command_round_trip_ms", "p95"),
    ),
    Measure(
        "transport_round_trip_p50_ms",
        "transport, p50",
        "ms",
        _quantile("transport_round_trip_ms", "p50"),
        "the transport’s own round trip (STUN)",
    ),
    *(
        Measure(
            f"{way}_{kind}_bytes_per_s",
            f"{way}, {'in all' if kind == 'total' else kind}",
            "bytes/s",
            _bytes(way, kind),
        )
        for way in ("received", "sent")
        for kind in ("total", *KINDS)
    ),
    Measure(
        "picture_drift_ms_per_min",
        "picture drift",
        "signed ms/min",
        _plain("picture_drift_ms_per_min"),
    ),
    Measure(
        "sound_drift_ms_per_min", "sound drift", "signed ms/min", _plain("sound_drift_ms_per_min")
    ),
    Measure(
        "lip_lag_ms",
        "lip lag",
        "signed ms",
        _plain("lip_lag_ms"),
        "by how much the voice comes after the lips",
    ),
    Measure("lip_correlation", "lip correlation", "1", _plain("lip_correlation")),
    Measure(
        "fail_safe_s",
        "fail-safe mode",
        "s",
        _told("viewer.streams.fail_safe_s"),
        "how long the policy was in fail-safe mode (thesis 3.3 and 3.5), as the server says",
    ),
    Measure(
        "crowd_pictures_per_s_mean",
        "crowd, mean",
        "per s",
        _told("crowd.pictures_per_s_mean"),
        "pictures that each of the other viewers received",
    ),
    Measure("crowd_pictures_per_s_min", "crowd, least", "per s", _told("crowd.pictures_per_s_min")),
    Measure(
        "crowd_lost_share",
        "crowd, lost",
        "share",
        _told("crowd.lost_share"),
        "of the packets to the other viewers",
    ),
    Measure(
        "server_cpu_share",
        "server CPU",
        "share",
        lambda result: None if result.server is None else result.server.cpu_share,
        "of one core",
    ),
    Measure(
        "server_memory_mib",
        "server memory",
        "MiB",
        lambda result: None if result.server is None else result.server.memory_mib,
    ),
)
MEASURES: Final[dict[str, Measure]] = {measure.name: measure for measure in _ALL}
