"""What a run measures: chapter 5's experiments as cells, each once, in an order that keeps links.

A cell that two experiments need is measured for the first of them; the report groups by profile
and system, so that the other finds it too.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Final

from e2e.lab.cell import PEERS, Cell, SystemName
from e2e.lab.link import load, names

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from e2e.lab.link import Profile

SECONDS: Final = 15.0
LONG_SECONDS: Final = 60.0
LONG_REPEATS: Final = 3
MU_LENGTHS_MS: Final = (100, 200, 300, 400, 500)
EVERY_SYSTEM: Final[tuple[SystemName, ...]] = (
    "thesis",
    "audio-master",
    "operator",
    "video-first",
    "stock",
    "livekit",
)
WATCHED: Final[tuple[SystemName, ...]] = (
    "thesis",
    "audio-master",
    "video-first",
    "stock",
    "livekit",
)
WIRED: Final = ("same-machine", "lan", "campus", "internet-5m")
NARROW: Final = ("wireless-2m", "wireless-1m", "modem-56k", "dual-modem", "isdn-64k")
TODAY: Final = ("lte-good", "lte-edge", "wifi-bad", "satellite")
CHANGING: Final = ("step-down", "outage")
CROWDS: Final = (1, 4, 8, 16)

TRIMMED: Final = (
    "E1: the outage, which is E6's.",
    "E2: the face on the LAN and the campus, which lie between those where it is; on the LAN all "
    "but thesis and audio-master.",
    "E3: on the two lines of the predictions the peers and video-first; on wireless-2m and "
    "lte-good, which are wide enough for all, operator and video-first.",
    "E5: audio-master on the page, which with a crowd of observers is the operator's.",
)
"""What is not measured, so that everything once ends within the hour."""

_LEFT_OUT: Final[dict[str, tuple[SystemName, ...]]] = {
    "dual-modem": ("video-first", *PEERS),
    "isdn-64k": ("video-first", *PEERS),
    "wireless-2m": ("operator", "video-first"),
    "lte-good": ("operator", "video-first"),
}

_CELL_S: Final = 4.0
"""Server, page, first picture and reading, beside the time that is measured."""
_STAGE_S: Final = 3.0
"""A new link with a new browser."""
_PAGE_BYTES: Final = 70_000
_JOIN_S: Final = 0.3
"""For each of the crowd."""
_LAST_S: Final = 20.0
"""How long is watched after the last change of a link."""
_CHANGING_S: Final = 30.0
_OWN_ERROR_S: Final = 40.0
_REPORT_S: Final = 20.0


def full(*, seconds: float = SECONDS, repeats: int = 1, only: Sequence[str] = ()) -> list[Cell]:
    """Plan every experiment, or of each what one of the patterns in `only` matches."""
    wanted = [
        cell.model_copy(update={"seconds": max(cell.seconds, seconds)}) for cell in _experiments()
    ]
    return _planned(wanted, repeats, only)


def quick(*, repeats: int = 1, only: Sequence[str] = ()) -> list[Cell]:
    """Plan a few short cells that touch every part."""
    short = 8.0
    wanted = [
        Cell(experiment="E1", profile="lan", system="thesis", audio_mu_ms=100, seconds=short),
        Cell(experiment="E1", profile="lan", system="thesis", audio_mu_ms=500, seconds=short),
        Cell(experiment="E2", profile="lan", system="audio-master", seconds=short),
        Cell(experiment="E2", profile="lan", system="stock", seconds=short),
        Cell(experiment="E2", profile="lan", system="livekit", seconds=short),
        Cell(experiment="E2", profile="lan", system="audio-master", content="face", seconds=10.0),
        Cell(experiment="E3", profile="wireless-1m", system="operator", seconds=short),
        Cell(experiment="E3", profile="wireless-1m", system="video-first", seconds=short),
        Cell(
            experiment="E4", profile="lan", system="audio-master", browser="firefox", seconds=short
        ),
        Cell(experiment="E5", profile="lan", system="operator", viewers=4, seconds=short),
        Cell(experiment="E6", profile="step-down", system="audio-master", seconds=14.0),
    ]
    return _planned(wanted, repeats, only)


def matches(cell: Cell, patterns: Sequence[str]) -> bool:
    """Say whether a pattern (``*`` and ``?`` as in a shell) is somewhere in the cell's variant."""
    return any(fnmatchcase(cell.variant, f"*{pattern}*") for pattern in patterns)


def changes(profile: Profile) -> bool:
    """Say whether a link of this profile is another one after its changes have begun."""
    ways = (profile.down, profile.up)
    return any(way.changes or way.trace is not None for way in ways)


def estimate_s(cells: Sequence[Cell], *, own_error: bool = False) -> float:
    """How long these cells will take, one after the other."""
    total_s = sum(cell_s(cell) for cell in cells) + (_REPORT_S if cells else 0.0)
    for before, cell in zip([None, *cells], cells, strict=False):
        if before is None or _stage(before) != _stage(cell) or changes(_profile(cell.profile)):
            total_s += _STAGE_S
    return total_s + (_OWN_ERROR_S if own_error else 0.0)


def cell_s(cell: Cell) -> float:
    """How long one cell will take where link and browser are there."""
    rate_bps = _profile(cell.profile).down.rate_bps
    loading_s = 8 * _PAGE_BYTES / rate_bps if rate_bps else 0.0
    return _CELL_S + loading_s + cell.seconds + _JOIN_S * (cell.viewers - 1)


def _experiments() -> Iterator[Cell]:
    for profile, mu_ms in product([*_profiles(but="outage")], MU_LENGTHS_MS):
        yield Cell(experiment="E1", profile=profile, system="thesis", audio_mu_ms=mu_ms)

    for profile, system in product(WIRED, WATCHED):
        if profile != "lan" or system in {"thesis", "audio-master"}:
            yield _cell("E2", profile, system)
        if profile in {"same-machine", "internet-5m"}:
            yield _cell("E2", profile, system).model_copy(update={"content": "face"})

    for profile, system in product(("internet-5m", *NARROW, *TODAY), EVERY_SYSTEM):
        if system not in _LEFT_OUT.get(profile, ()):
            yield _cell("E3", profile, system)
    yield _cell("E3", "same-machine", "operator")

    three: tuple[SystemName, ...] = ("thesis", "audio-master", "stock")
    for profile, system in product(("same-machine", "internet-5m"), three):
        yield _cell("E4", profile, system)
        yield _cell("E4", profile, system).model_copy(update={"browser": "firefox"})

    crowded: tuple[SystemName, ...] = ("thesis", "operator", "stock")
    for viewers, system in product(CROWDS, crowded):
        yield _cell("E5", "same-machine", system).model_copy(update={"viewers": viewers})

    for profile, system in product(CHANGING, EVERY_SYSTEM):
        seconds = max(_CHANGING_S, _last_change_s(_profile(profile)) + _LAST_S)
        yield _cell("E6", profile, system).model_copy(update={"seconds": seconds})


def _cell(experiment: str, profile: str, system: SystemName) -> Cell:
    mu_ms = 500 if system == "thesis" else None
    tree = {"experiment": experiment, "profile": profile, "system": system, "audio_mu_ms": mu_ms}
    return Cell.model_validate(tree)


def _planned(wanted: Iterable[Cell], repeats: int, only: Sequence[str]) -> list[Cell]:
    """Take each measurement once; repetitions one after the other, links and browsers together."""
    once: dict[str, Cell] = {}
    for cell in wanted:
        if not only or matches(cell, only):
            once.setdefault(cell.variant.partition("/")[2], cell)
    profiles = [*_profiles()]
    in_order = sorted(
        once.values(), key=lambda cell: (profiles.index(cell.profile), cell.browser != "chromium")
    )
    return [
        cell.model_copy(update={"repeat": repeat}) for repeat in range(repeats) for cell in in_order
    ]


def _profiles(*, but: str = "") -> list[str]:
    """Give the shipped profiles, chapter 5's first, but one."""
    known = [*WIRED, *NARROW, *TODAY, *CHANGING]
    return [name for name in [*known, *sorted({*names()} - {*known})] if name != but]


@cache
def _profile(name: str) -> Profile:
    return load(name)


def _last_change_s(profile: Profile) -> float:
    return max(way.steps()[-1][0] for way in (profile.down, profile.up))


def _stage(cell: Cell) -> tuple[str, str, int]:
    return cell.profile, cell.browser, cell.repeat
