"""What a run measures: chapter 5's experiments as cells, each once, in an order that keeps links.

A cell that two experiments need is measured for the first of them; the report groups by profile
and system, so that the other finds it too.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from functools import cache
from itertools import chain, product
from typing import TYPE_CHECKING, Final

from e2e.lab.cell import Cell, SystemName
from e2e.lab.client2004.table import MU_LENGTHS_MS
from e2e.lab.link import load, names

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from e2e.lab.link import Profile

SECONDS: Final = 15.0
LONG_SECONDS: Final = 60.0
LONG_REPEATS: Final = 3
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
IN_BROWSERS: Final[tuple[SystemName, ...]] = ("thesis", "audio-master", "stock")
CROWDED: Final[tuple[SystemName, ...]] = ("thesis", "operator", "stock")
"""With a crowd of observers, who are audio-master's, the page is the operator's."""

TRIMMED: Final[dict[str, tuple[str, ...]]] = {
    "E1: the outage, which is E6's": ("E1/outage/*",),
    "E2: on the LAN and the campus the face, and all but thesis and audio-master": (
        *("E2/lan/*/face", "E2/lan/video-first", "E2/lan/stock", "E2/lan/livekit"),
        *("E2/campus/*/face", "E2/campus/video-first", "E2/campus/stock", "E2/campus/livekit"),
    ),
    "E2: on the same machine the face of video-first and livekit": (
        *("E2/same-machine/video-first/face", "E2/same-machine/livekit/face"),
    ),
    "E3: on dual-modem and isdn-64k, which are predictions, all but thesis and audio-master": (
        *("E3/dual-modem/operator", "E3/dual-modem/video-first"),
        *("E3/dual-modem/stock", "E3/dual-modem/livekit"),
        *("E3/isdn-64k/operator", "E3/isdn-64k/video-first"),
        *("E3/isdn-64k/stock", "E3/isdn-64k/livekit"),
    ),
    "E3: on wireless-2m and lte-good, wide enough for all, operator, video-first and livekit": (
        *("E3/wireless-2m/operator", "E3/wireless-2m/video-first", "E3/wireless-2m/livekit"),
        *("E3/lte-good/operator", "E3/lte-good/video-first", "E3/lte-good/livekit"),
    ),
    "E3: on the satellite video-first": ("E3/satellite/video-first",),
    "E5: 16 viewers of stock, which saturates a core with 8": ("E5/*/stock/16-viewers",),
    "E6: video-first in the outage": ("E6/outage/video-first/*",),
}
"""What is left out of the plan that nobody narrowed, so that it ends within the hour: patterns of
variants."""

_CELL_S: Final = 4.0
"""Server, page, first picture and reading, beside the time that is measured."""
_STAGE_S: Final = 3.0
"""A new link with a new browser."""
_FIRST_BYTES: Final = 100_000
"""What goes over the link until there is a picture."""
_JOIN_S: Final = 0.3
"""For each of the crowd."""
_LAST_S: Final = 20.0
"""How long is watched after the last change of a link."""
_CHANGING_S: Final = 30.0
_OWN_ERROR_S: Final = 40.0
_VERIFIED_S: Final = 10.0
"""One profile of the emulator."""
_REPORT_S: Final = 20.0


def full(
    *,
    seconds: float = SECONDS,
    repeats: int = 1,
    only: Sequence[str] = (),
    trimmed: bool = True,
) -> list[Cell]:
    """Plan every experiment, or of each what one of the patterns in `only` matches.

    Without what `TRIMMED` has, unless `trimmed` is false.
    """
    wanted = [
        cell.model_copy(update={"seconds": max(cell.seconds, seconds)})
        for cell in everything()
        if not (trimmed and _is_trimmed(cell))
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
        Cell(
            experiment="E4", profile="lan", system="audio-master", browser="firefox", seconds=short
        ),
        Cell(experiment="E5", profile="lan", system="operator", viewers=4, seconds=short),
        Cell(experiment="E6", profile="step-down", system="video-first", seconds=14.0),
    ]
    return _planned(wanted, repeats, only)


def matches(cell: Cell, patterns: Sequence[str]) -> bool:
    """Say whether a pattern (``*`` and ``?`` as in a shell) is somewhere in the cell's variant."""
    return any(fnmatchcase(cell.variant, f"*{pattern}*") for pattern in patterns)


def changes(profile: Profile) -> bool:
    """Say whether a link of this profile is another one after its changes have begun."""
    ways = (profile.down, profile.up)
    return any(way.changes or way.trace is not None for way in ways)


def estimate_s(cells: Sequence[Cell], *, own_error: bool = False, emulator: bool = False) -> float:
    """How long these cells will take, one after the other, and what is measured before them."""
    total_s = sum(cell_s(cell) for cell in cells) + (_REPORT_S if cells else 0.0)
    for before, cell in zip([None, *cells], cells, strict=False):
        if before is None or _stage(before) != _stage(cell) or changes(_profile(cell.profile)):
            total_s += _STAGE_S
    if emulator:
        total_s += _VERIFIED_S * len({cell.profile for cell in cells})
    return total_s + (_OWN_ERROR_S if own_error else 0.0)


def cell_s(cell: Cell) -> float:
    """How long one cell will take where link and browser are there."""
    rate_bps = _profile(cell.profile).down.rate_bps
    loading_s = 8 * _FIRST_BYTES / rate_bps if rate_bps else 0.0
    return _CELL_S + loading_s + cell.seconds + _JOIN_S * (cell.viewers - 1)


def everything() -> Iterator[Cell]:
    """Give what every experiment needs, untrimmed."""
    for profile, mu_ms in product(_profiles(), MU_LENGTHS_MS):
        yield Cell(experiment="E1", profile=profile, system="thesis", audio_mu_ms=mu_ms)

    for profile, system in product(WIRED, WATCHED):
        yield _cell("E2", profile, system)
        yield _cell("E2", profile, system, content="face")

    for profile, system in product(("internet-5m", *NARROW, *TODAY), EVERY_SYSTEM):
        yield _cell("E3", profile, system)
    yield _cell("E3", "same-machine", "operator")

    for profile, system in product(("same-machine", "internet-5m"), IN_BROWSERS):
        yield _cell("E4", profile, system)
        yield _cell("E4", profile, system, browser="firefox")

    for viewers, system in product(CROWDS, CROWDED):
        yield _cell("E5", "same-machine", system, viewers=viewers)

    for profile, system in product(CHANGING, EVERY_SYSTEM):
        seconds = max(_CHANGING_S, _last_change_s(_profile(profile)) + _LAST_S)
        yield _cell("E6", profile, system, seconds=seconds)


def _is_trimmed(cell: Cell) -> bool:
    patterns = chain.from_iterable(TRIMMED.values())
    return any(fnmatchcase(cell.variant, pattern) for pattern in patterns)


def _cell(experiment: str, profile: str, system: SystemName, **more: object) -> Cell:
    mu_ms = 500 if system == "thesis" else None
    tree = {"experiment": experiment, "profile": profile, "system": system, "audio_mu_ms": mu_ms}
    return Cell.model_validate(tree | more)


def _planned(wanted: Iterable[Cell], repeats: int, only: Sequence[str]) -> list[Cell]:
    """Take each measurement once; repetitions one after the other, links and browsers together."""
    cells = in_order(wanted, only)
    return [
        cell.model_copy(update={"repeat": repeat}) for repeat in range(repeats) for cell in cells
    ]


def in_order(wanted: Iterable[Cell], only: Sequence[str]) -> list[Cell]:
    """Take each measurement that a pattern in `only` matches once, links and browsers together."""
    once: dict[str, Cell] = {}
    for cell in wanted:
        if not only or matches(cell, only):
            once.setdefault(cell.variant.partition("/")[2], cell)
    profiles = _profiles()
    return sorted(
        once.values(), key=lambda cell: (profiles.index(cell.profile), cell.browser != "chromium")
    )


def _profiles() -> list[str]:
    """Give the shipped profiles, chapter 5's first."""
    known = [*WIRED, *NARROW, *TODAY, *CHANGING]
    return [*known, *sorted({*names()} - {*known})]


@cache
def _profile(name: str) -> Profile:
    return load(name)


def _last_change_s(profile: Profile) -> float:
    return max(way.steps()[-1][0] for way in (profile.down, profile.up))


def _stage(cell: Cell) -> tuple[str, str, int]:
    return cell.profile, cell.browser, cell.repeat
