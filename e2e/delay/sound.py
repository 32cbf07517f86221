"""The sound at the ear: our own player, the browser's, and the peers, over links of each kind.

Where a goal compares, the other is measured as often as ours; elsewhere it stands beside it and is
measured once. Speech is played once over some of the links, for its quality.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from e2e.delay import judging, plan
from e2e.delay.cell import Cell
from e2e.delay.judging import Goal
from e2e.delay.names import AGE, GIVEN, SYSTEMS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.delay.cell import SystemName
    from e2e.measure.row import Row

REPEATS: Final = 3
SECONDS: Final = 60.0
LONG_SECONDS: Final = 1800.0
"""How long one observer listens on the same machine, so that a slow drift is seen."""
OUTAGE_SECONDS: Final = 30.0
"""The link is silent from 5 s to 7 s."""
DRIFT: Final = "sound_drift_ms_per_min"
BROWSERS: Final = "browser’s player"
SPOKEN: Final[tuple[tuple[str, SystemName], ...]] = (
    ("same-machine", "audio-master"),
    ("stalls", "audio-master"),
    ("cafe", "audio-master"),
    ("wifi-bad", "audio-master"),
    ("modem-56k", "operator"),
)
"""Where and to whom the voice speaks."""

_STOCK: Final = SYSTEMS["stock"]
_LIVEKIT: Final = SYSTEMS["livekit-whip"]
_COLUMNS: Final[judging.Columns] = {
    "WAX": lambda goal, cell: (
        (cell.system, cell.player) == (goal.system, "auto")
        and (cell.seconds == LONG_SECONDS) == (goal.measure == DRIFT)
    ),
    BROWSERS: lambda goal, cell: cell.system == goal.system and cell.player == "browser",
    **judging.columns_of(("video-first", "stock", "livekit-whip")),
}
COLUMNS: Final = tuple(_COLUMNS)
NOTES: Final = (
    "Judged is the median over the repetitions. What no goal compares with was measured once, and "
    "so was the half hour, in which the sound’s delay may drift by 5 ms.",
    "Age of the sound: from capture to the ear, a sound device (PulseAudio’s null sink) whose "
    "output is recorded, so that the browser’s way to the device is included.",
    "Concealed is what was heard and never sent: by our own player’s count of every sample, or by "
    "the browser’s. Stretched is what was heard twice.",
    "video-first: an observer whose picture waits for no sound, so that it is as old as its way.",
    "Speech: ViSQOL’s mean opinion score (1 to 5) of what the ear recorded, against the voice that "
    "was played; the median over its sentences.",
    AGE,
    *GIVEN,
)


def goals(drives: Sequence[str] = ()) -> Iterator[Goal]:
    """Give the goals; `drives` are recorded drives over cellular links."""
    here = "same-machine"
    operator: Final[SystemName] = "operator"
    observer: Final[SystemName] = "audio-master"
    p50, p95, made_up = "sound_age_p50_ms", "sound_age_p95_ms", "concealed_percent"
    peers: Any = {"of": (_STOCK, _LIVEKIT)}
    browsers: Any = {"of": (BROWSERS,)}
    yield Goal(here, operator, p50, 50, times=0.6, **peers)
    yield Goal(here, operator, p95, 60)
    yield Goal(here, observer, p50, 62)
    yield Goal(here, observer, DRIFT, 5.0 / (LONG_SECONDS / 60))
    yield Goal("stalls", observer, p50, 180)
    yield Goal("stalls", observer, p95, 220)
    yield Goal("stalls", observer, made_up, 0.5)
    yield Goal("stalls", observer, "stretched_percent", 0.5)
    yield Goal("internet-5m", operator, "picture_age_p95_ms", times=0.85, **peers)
    yield Goal("cafe", operator, p50, 100)
    yield Goal("cafe", operator, "picture_age_p50_ms", 50)
    yield Goal("wifi-bad", observer, made_up, 0.5)
    yield Goal("wifi-bad", observer, p50, times=0.8, **browsers)
    yield Goal("modem-56k", operator, made_up, 1.0)
    yield Goal("modem-56k", operator, p50, times=0.8, **browsers)
    for system in (operator, observer):
        yield Goal("outage", system, "picture_recovered_ms", 500)
        yield Goal("outage", system, "full_after_ms", 3000)
    for drive in drives:
        yield Goal(drive, observer, p50, of=(_STOCK,))
        yield Goal(drive, observer, made_up, times=0.5, of=(_STOCK,))
        yield Goal(drive, operator, p50, times=0.7, of=(_STOCK,))
        yield Goal(drive, operator, "picture_age_p95_ms", times=0.5, of=(_STOCK,))
    for profile in (here, "internet-5m", "wireless-2m", "wireless-1m", "lte-good"):
        yield Goal(profile, observer, "joined_skew_p95_ms", 20)
    for profile in ("wifi-bad", "cafe", "stalls"):
        yield Goal(profile, observer, "joined_skew_p95_ms", 20)
    for profile, system in SPOKEN:
        yield Goal(
            profile,
            system,
            "speech_quality",
            content="talking-head",
            more_is_better=True,
            **browsers,
        )
    yield Goal(here, operator, "browser_cpu", plus=5.0, **browsers)


def planned(
    *, drives: Sequence[str] = (), repeats: int = REPEATS, only: Sequence[str] = ()
) -> list[Cell]:
    """Plan the cells: what is judged in each repetition, and in the first what stands beside."""
    again = list(_judged(drives))
    first = plan.in_order([*again, *_beside(drives)], only)
    rest = plan.in_order(again, only)
    repeated = [
        cell.model_copy(update={"repeat": repeat})
        for repeat in range(repeats)
        for cell in (rest if repeat else first)
    ]
    return [*repeated, *plan.in_order(_long(), only)]


def derive(rows: Sequence[Row]) -> list[Row]:
    """Judge every goal of which there is a cell of ours; the drives are known by their names."""
    measured = {row.detail["cell"]["profile"] for row in rows if "cell" in row.detail}
    drives = sorted(one for one in measured if "/" in one)
    return judging.derive(goals(drives), _COLUMNS, rows)


def _judged(drives: Sequence[str]) -> Iterator[Cell]:
    both: tuple[SystemName, ...] = ("operator", "audio-master")
    for system in both:
        yield _cell("same-machine", system)
    yield _cell("same-machine", "operator", player="browser")
    yield _cell("stalls", "audio-master")
    for system in both:
        yield _cell("internet-5m", system)
        yield _cell("cafe", system)
    for profile, system in (("wifi-bad", both[1]), ("modem-56k", both[0])):
        yield _cell(profile, system)
        yield _cell(profile, system, player="browser")
    for profile in ("wireless-2m", "wireless-1m", "lte-good"):
        yield _cell(profile, "audio-master")
    for system in both:
        yield _cell("outage", system, seconds=OUTAGE_SECONDS)
    for profile in ("same-machine", "internet-5m"):
        yield _cell(profile, "stock")
        yield _cell(profile, "livekit-whip")
    for drive in drives:
        for system in (*both, "stock"):
            yield _cell(drive, system)


def _beside(drives: Sequence[str]) -> Iterator[Cell]:
    yield _cell("same-machine", "audio-master", player="browser")
    yield _cell("stalls", "audio-master", player="browser")
    yield _cell("cafe", "operator", player="browser")
    yield _cell("internet-5m", "operator", player="browser")
    for profile in ("internet-5m", "cafe"):
        yield _cell(profile, "video-first")
    for profile in ("stalls", "cafe", "wifi-bad", "modem-56k"):
        yield _cell(profile, "stock")
    for profile in ("stalls", "cafe", "wifi-bad"):
        yield _cell(profile, "livekit-whip")
    for drive in drives:
        yield _cell(drive, "audio-master", player="browser")
    for profile, system in SPOKEN:
        for player in ("auto", "browser"):
            yield _cell(profile, system, player=player, content="talking-head")


def _long() -> Iterator[Cell]:
    yield _cell("same-machine", "audio-master", seconds=LONG_SECONDS)


def _cell(profile: str, system: SystemName, **more: Any) -> Cell:
    cell = {"experiment": "G", "profile": profile, "system": system, "seconds": SECONDS}
    return Cell.model_validate(cell | more)
