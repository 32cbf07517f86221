"""What a run measures: chapter 5's experiments as cells, each once, in an order that keeps links.

A cell that two experiments need is measured for the first of them; the report groups by profile
and system, so that the other finds it too.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from itertools import chain, product
from typing import TYPE_CHECKING, Any, Final

from tests.baseline.client2004.table import MU_LENGTHS_MS

from e2e.delay.cell import Cell, SystemName
from e2e.delay.names import CHANGING, CHAPTER5, NARROW, PEERS, SYSTEMS, TODAY, WIRED, place, profile

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

SECONDS: Final = 15.0
LONG_SECONDS: Final = 60.0
QUICK_SECONDS: Final = 8.0
LONG_REPEATS: Final = 3
EVERY_SYSTEM: Final[tuple[SystemName, ...]] = tuple(SYSTEMS)
WATCHED: Final[tuple[SystemName, ...]] = tuple(system for system in SYSTEMS if system != "operator")
IN_BROWSERS: Final[tuple[SystemName, ...]] = ("thesis", "audio-master", "stock")
CROWDS: Final = (1, 4, 8, 16)
CROWDED: Final[tuple[SystemName, ...]] = ("thesis", "operator", "stock")
"""With a crowd of observers, who are audio-master's, the page is the operator's."""

TRIMMED: Final[dict[str, tuple[str, ...]]] = {
    "E1: the outage, which is E6's": ("E1/outage/*",),
    "E2: on the LAN and the campus the talking head, and all but thesis and audio-master": (
        *("E2/lan/*/talking-head", "E2/lan/video-first", "E2/lan/stock", "E2/lan/livekit*"),
        *("E2/campus/*/talking-head", "E2/campus/video-first", "E2/campus/stock"),
        "E2/campus/livekit*",
    ),
    "E2: the talking head of video-first on the same machine, of LiveKit but over 5 Mbit/s": (
        *("E2/same-machine/video-first/talking-head", "E2/same-machine/livekit*/talking-head"),
        "E2/internet-5m/livekit-whip/talking-head",
    ),
    "E3: on dual-modem and isdn-64k, which are predictions, all but thesis and audio-master": (
        *("E3/dual-modem/operator", "E3/dual-modem/video-first"),
        *("E3/dual-modem/stock", "E3/dual-modem/livekit*"),
        *("E3/isdn-64k/operator", "E3/isdn-64k/video-first"),
        *("E3/isdn-64k/stock", "E3/isdn-64k/livekit*"),
    ),
    "E3: on wireless-2m and lte-good, wide enough for all, operator, video-first and LiveKit": (
        *("E3/wireless-2m/operator", "E3/wireless-2m/video-first", "E3/wireless-2m/livekit*"),
        *("E3/lte-good/operator", "E3/lte-good/video-first", "E3/lte-good/livekit*"),
    ),
    "E3: on the satellite video-first and LiveKit's one layer": (
        *("E3/satellite/video-first", "E3/satellite/livekit-whip"),
    ),
    "E5: 16 viewers of stock, which saturates a core with 8": ("E5/*/stock/16-viewers",),
    "E6: video-first and LiveKit's one layer in the outage": (
        *("E6/outage/video-first/*", "E6/outage/livekit-whip/*"),
    ),
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
_REST_S: Final = 20.0
"""Looking at the machine, and the report."""
_OWN_ERROR_S: Final = 30.0


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
    return repeated(in_order(wanted, only), repeats)


def quick(*, repeats: int = 1, only: Sequence[str] = ()) -> list[Cell]:
    """Plan a few short cells that touch every part."""
    wanted = [
        _cell("E1", "lan", "thesis", audio_mu_ms=100),
        _cell("E1", "lan", "thesis", audio_mu_ms=500),
        _cell("E2", "lan", "audio-master"),
        *(_cell("E2", "lan", peer) for peer in PEERS),
        _cell("E2", "lan", "audio-master", content="talking-head", seconds=10.0),
        _cell("E3", "wireless-1m", "operator"),
        _cell("E4", "lan", "audio-master", browser="firefox"),
        _cell("E5", "lan", "operator", viewers=4),
        _cell("E6", "step-down", "video-first", seconds=14.0),
    ]
    short = (
        cell if "seconds" in cell.model_fields_set else _lasting(cell, QUICK_SECONDS)
        for cell in wanted
    )
    return repeated(in_order(short, only), repeats)


def everything() -> Iterator[Cell]:
    """Give what every experiment needs, untrimmed."""
    for name, mu_ms in product(CHAPTER5, MU_LENGTHS_MS):
        yield _cell("E1", name, "thesis", audio_mu_ms=mu_ms)
    for name, system, content in product(WIRED, WATCHED, ("testcard", "talking-head")):
        yield _cell("E2", name, system, content=content)
    for name, system in product(("internet-5m", *NARROW, *TODAY), EVERY_SYSTEM):
        yield _cell("E3", name, system)
    yield _cell("E3", "same-machine", "operator")
    for name, system, browser in product(
        ("same-machine", "internet-5m"), IN_BROWSERS, ("chromium", "firefox")
    ):
        yield _cell("E4", name, system, browser=browser)
    for viewers, system in product(CROWDS, CROWDED):
        yield _cell("E5", "same-machine", system, viewers=viewers)
    for name, system in product(CHANGING, EVERY_SYSTEM):
        ways = (profile(name).down, profile(name).up)
        last_s = max(way.steps()[-1][0] for way in ways)
        yield _cell("E6", name, system, seconds=max(_CHANGING_S, last_s + _LAST_S))


def matches(cell: Cell, patterns: Sequence[str]) -> bool:
    """Say whether a pattern (``*`` and ``?`` as in a shell) is somewhere in the cell's variant."""
    return any(fnmatchcase(cell.variant, f"*{pattern}*") for pattern in patterns)


def in_order(wanted: Iterable[Cell], only: Sequence[str]) -> list[Cell]:
    """Take each measurement that a pattern in `only` matches once, links and browsers together."""
    once: dict[str, Cell] = {}
    for cell in wanted:
        if not only or matches(cell, only):
            once.setdefault(cell.variant.partition("/")[2], cell)
    return sorted(once.values(), key=lambda cell: (place(cell.profile), cell.browser != "chromium"))


def repeated(cells: Sequence[Cell], repeats: int) -> list[Cell]:
    """Measure them all, and then all again: so repetitions are far from each other in time."""
    return [
        cell.model_copy(update={"repeat": repeat}) for repeat in range(repeats) for cell in cells
    ]


def changes(name: str) -> bool:
    """Say whether a link of this profile is another one after its changes have begun."""
    ways = (profile(name).down, profile(name).up)
    return any(way.changes or way.trace is not None for way in ways)


def estimate_s(cells: Sequence[Cell], *, own_error: bool = True) -> float:
    """How long these cells will take, one after the other, and what is measured beside them."""
    total_s = _REST_S + (_OWN_ERROR_S if own_error else 0.0) + sum(map(_cell_s, cells))
    stages = [(cell.profile, cell.browser, cell.repeat) for cell in cells]
    for before, stage in zip([None, *stages], stages, strict=False):
        if before != stage or changes(stage[0]):
            total_s += _STAGE_S
    return total_s


def _cell_s(cell: Cell) -> float:
    rate_bps = profile(cell.profile).down.rate_bps
    loading_s = 8 * _FIRST_BYTES / rate_bps if rate_bps else 0.0
    return _CELL_S + loading_s + cell.seconds + _JOIN_S * (cell.viewers - 1)


def _is_trimmed(cell: Cell) -> bool:
    patterns = chain.from_iterable(TRIMMED.values())
    return any(fnmatchcase(cell.variant, pattern) for pattern in patterns)


def _cell(experiment: str, name: str, system: SystemName, **more: Any) -> Cell:
    mu_ms = {"audio_mu_ms": 500} if system == "thesis" else {}
    return Cell.model_validate(
        {"experiment": experiment, "profile": name, "system": system, **mu_ms, **more}
    )


def _lasting(cell: Cell, seconds: float) -> Cell:
    return cell.model_copy(update={"seconds": seconds})
