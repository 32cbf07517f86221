"""How much later commands arrive while their operator speaks."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from statistics import fmean
from typing import TYPE_CHECKING, Final

from e2e.delay.voice.stage import staged
from e2e.measure.ear import SILENT
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged, summarize

if TYPE_CHECKING:
    from e2e.delay.voice.stage import Stage

SECONDS: Final = 25.0
_REST_S: Final = 2.0
"""Between two stretches: commands still in flight belong to neither."""
_QUANTILES: Final = ("median", "p95", "p99", "max")


@dataclass(slots=True)
class Stretches:
    """The results of all stretches of one kind; ages in ms, measured from a common moment."""

    ages_ms: list[float] = field(default_factory=list)
    accepted: float = 0.0
    too_old: float = 0.0
    played: list[bool] = field(default_factory=list)
    """For each 10 ms at the robot's speaker, whether it sounded."""


async def command_age(profile: str, goal_ms: float, n: int) -> list[Row]:
    """Drive, speaking and silent in turn, `n` times each, and compare."""
    silent, speaking = Stretches(), Stretches()
    async with staged(profile) as stage:
        for number in range(n):
            pair = (silent, speaking) if number % 2 else (speaking, silent)
            for one in pair:
                await _stretch(stage, one, speaks=one is speaking)
    return rows(profile, goal_ms, silent, speaking)


def rows(profile: str, goal_ms: float, silent: Stretches, speaking: Stretches) -> list[Row]:
    """Compare the quantiles of both; raises `MeasureError` if one is empty.

    A command that was refused for its age while its operator spoke also misses the goal.
    """
    base, with_voice = summarize(silent.ages_ms), summarize(speaking.ages_ms)
    more = {name: getattr(with_voice, name) - getattr(base, name) for name in _QUANTILES}
    refused = max(0, round(speaking.too_old - silent.too_old))
    key = f"command-age/{profile}"
    what = f"a command’s age, more while its operator speaks: {profile}"
    detail = {
        "refused for their age, more": refused,
        "sounding at the robot’s speaker, %": 100 * fmean(speaking.played or [False]),
    }
    row = judged(key, what, "ms", more, goal_ms, n=with_voice.n, column="p99", detail=detail)
    return [row.model_copy(update={"met": row.met and not refused})]


async def _stretch(stage: Stage, into: Stretches, *, speaks: bool) -> None:
    held = ("ArrowUp", "KeyT") if speaks else ("ArrowUp",)
    for key in held:
        await stage.window.keyboard.down(key)
    await stage.taken()
    tap = stage.ear.tap()
    before = (await stage.system.status())["counters"]
    from_ms = float(await stage.window.evaluate("performance.now()"))
    await asyncio.sleep(SECONDS)
    to_ms = float(await stage.window.evaluate("performance.now()"))
    after = (await stage.system.status())["counters"]
    for key in held:
        await stage.window.keyboard.up(key)
    into.played += [block.rms > SILENT for block in tap.heard]
    await asyncio.sleep(_REST_S)
    pings = (await stage.taken())["pings"]
    into.ages_ms += [
        server_ms - sent_ms for sent_ms, server_ms in pings if from_ms <= sent_ms <= to_ms
    ]
    into.accepted += _grown(before, after, "commands.accepted")
    into.too_old += _grown(before, after, "commands.refused.too_old")
    if into.accepted == 0:
        raise MeasureError("no command was accepted")


def _grown(before: dict[str, float], after: dict[str, float], counter: str) -> float:
    return after.get(counter, 0.0) - before.get(counter, 0.0)
