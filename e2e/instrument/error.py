"""The instrument's own error, measured by two of them on one page, and by a source that lies."""

from __future__ import annotations

import asyncio
import math
import statistics
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import tomlkit

from e2e.delay.systems.served import PORT
from e2e.delay.systems.wax import serving
from e2e.harness.scripts import press
from e2e.harness.wait import eventually
from e2e.instrument.cards import LIE_MS, lies
from e2e.instrument.instrument import Instrument, preload
from e2e.instrument.sums import figures, picture_ages, sound_bursts, window
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row
from e2e.measure.row import judged as beside

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from e2e.delay.browser import Browser
    from e2e.delay.readings import Readings
    from e2e.link import Link

LIMIT_MS: Final = 5.0
# A small picture, so that the encoder's own jitter is small.
_CONFIG: Final = {
    "server": {"host": "0.0.0.0", "port": PORT},
    "video": {
        "source": "e2e.instrument.cards:LyingVideo",
        "width": 320,
        "height": 240,
        "renditions": [{"width": 320, "height": 240, "fps": 30.0, "bitrate_bps": 350_000}],
    },
    "audio": {"source": "e2e.instrument.cards:LyingAudio"},
}
_SETTLE_S: Final = 3.0
_LEAST_S: Final = 15.0
_MORE_S: Final = 5.0
_MOST_S: Final = 45.0
_WITHIN_S: Final = 30.0
_TWO: Final = ("__waxLabOne", "__waxLabTwo")


async def own_error(link: Link, browser: Browser, folder: Path) -> list[Row]:
    """Watch WAX over a link that adds nothing, for 15 s after the start.

    The goals are that two instruments on the page agree within 5 ms, and that the source's lies of
    100 ms are read as 100 ± 5 ms, for picture and sound. If a busy machine spreads the readings, it
    continues until they are conclusive, for up to 45 s. Raises `MeasureError` if server or browser
    do not work, or if the instrument does not count what the page's built-in player plays.
    """
    async with (
        serving(link.server, folder, tomlkit.dumps(_CONFIG)) as served,
        browser.window("\n".join(map(preload, _TWO))) as window,
    ):
        await window.goto(served.url)
        one, two = (Instrument(window.evaluate, browser.ear, name=name) for name in _TWO)
        await eventually(one.sees_picture, "there is a picture", within_s=_WITHIN_S)
        await window.evaluate(press("Turn sound on"))
        if not await one.tap.hears(_WITHIN_S):
            raise MeasureError(f"the instrument's own error: no sound within {_WITHIN_S:g} s")
        began_s = time.monotonic()
        await asyncio.sleep(_SETTLE_S + _LEAST_S)
        while True:
            first = await one.readings()
            found, is_certain = judged(first, await two.readings())
            if not first.player_sound.at_ms:
                raise MeasureError("the instrument's own error: nothing is counted of the player")
            if is_certain or time.monotonic() - began_s - _SETTLE_S >= _MOST_S:
                return found
            await asyncio.sleep(_MORE_S)


def judged(first: Readings, second: Readings) -> tuple[list[Row], bool]:
    """Compare two readings of one page whose source lied; return also whether they are conclusive.

    There is a row for picture and one for sound: the error of the worse of both checks.
    """
    to_ms = min((read.pictures.at_ms or [read.opened_ms])[-1] for read in (first, second))
    within = window(first, settle_s=_SETTLE_S, to_ms=to_ms)
    one, two = (
        figures(read, window(read, settle_s=_SETTLE_S, to_ms=to_ms)) for read in (first, second)
    )
    rows, is_certain = [], True
    for kind, ages in (("picture", picture_ages(first.pictures)), ("sound", sound_bursts(first))):
        a, b = (each.get(f"{kind}_age_p50_ms") for each in (one, two))
        read = shift((at - age, age) for at, age in ages if within.has(at))
        known = a is not None and b is not None and read is not None
        off_ms = max(abs(a - b), abs(read.ms - LIE_MS)) if known else None  # type: ignore[operator, union-attr]  # known
        rows.append(_row(kind, off_ms))
        is_certain &= read is not None and read.is_clear
    return rows, is_certain


def _row(kind: str, off_ms: float | None) -> Row:
    """Make a row; a figure that could not be read misses the limit."""
    what = f"the instrument, {kind}: two on a page, and {LIE_MS} ms in the source, are wrong by"
    key, off = f"instrument/{kind}", {"off": off_ms}
    row = beside(key, what, "ms", off, LIMIT_MS, n=1, column="off")
    return row.model_copy(update={"met": bool(row.met)})


# --- what is made of a clock that lies (pure) ---

_LEAST_LIES: Final = 4


@dataclass(frozen=True, slots=True)
class Shift:
    """How much older the lying seconds were read than the honest ones around them.

    `uncertain_ms` is the standard error of `ms`, from the spread of the lies: the machine's jitter,
    which no instrument can remove.
    """

    ms: float
    uncertain_ms: float

    @property
    def is_clear(self) -> bool:
        """Whether it is inside or outside the limit by two standard errors or more."""
        return abs(abs(self.ms - LIE_MS) - LIMIT_MS) >= 2 * self.uncertain_ms


def shift(read: Iterable[tuple[float, float]]) -> Shift | None:
    """Compare the lying seconds with the honest ones around them.

    `read` are the stamps as read, and ages. For each lying second with both neighbours, take its
    mean minus the neighbours' mean; return the median of these differences, None for fewer than 4.
    Means are used because ages come in steps of the screen's refresh, between which a median jumps;
    the outer tenths are left out because a machine that stalls makes a few pictures old.
    """
    seconds: dict[int, list[float]] = {}
    for stamp_ms, age_ms in read:
        # The stamp as read and the true one must agree on whether it lies.
        if lies(stamp_ms) == lies(stamp_ms + LIE_MS):
            seconds.setdefault(math.floor((stamp_ms + 500) / 1000), []).append(age_ms)
    means = {second: _mean(ages) for second, ages in seconds.items()}
    shifts = [
        mean - (means[second - 1] + means[second + 1]) / 2
        for second, mean in means.items()
        if second % 2 == 1 and second - 1 in means and second + 1 in means
    ]
    if len(shifts) < _LEAST_LIES:
        return None
    middle = statistics.median(shifts)
    # For a normal distribution: the median's standard error, from the median absolute deviation.
    deviation = 1.4826 * statistics.median(abs(one - middle) for one in shifts)
    return Shift(middle, 1.2533 * deviation / math.sqrt(len(shifts)))


def _mean(ages: list[float]) -> float:
    outer = len(ages) // 10
    return statistics.fmean(sorted(ages)[outer : len(ages) - outer])
