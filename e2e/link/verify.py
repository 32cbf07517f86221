"""The link against its own profiles: real packets through the real devices, at most 10 s each.

Three trains in both directions at once: spaced packets for delay, jitter, stalls; dense small ones
for loss, where there is any; more than the rate for rate and queue, through all changes. Two
things differ from the profile, so that it fits the time: stalls come at least every 0.8 s and
changes each 1.2 s.
"""

from __future__ import annotations

import asyncio
import time
from asyncio.subprocess import PIPE
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from pydantic import TypeAdapter
from tests.link.errors import LinkError
from tests.link.profile import load

from e2e.link.judge import Judge
from e2e.link.link import Link
from e2e.link.probe import Plan, Record
from e2e.link.trains import WAYS, WayName, plan_of, shortened, timetable_of

if TYPE_CHECKING:
    from asyncio.subprocess import Process

    from e2e.link.expect import Figure
    from e2e.link.link import End
    from e2e.link.statistics import Statistics

_RECORD: Final = TypeAdapter(Record)
_PLAN: Final = TypeAdapter(Plan)


@dataclass(frozen=True, slots=True)
class Verified:
    """What was found for one profile."""

    profile: str
    took_s: float
    figures: dict[WayName, list[Figure]]
    notes: list[str]
    statistics: Statistics

    @property
    def ok(self) -> bool:
        return all(figure.ok for figures in self.figures.values() for figure in figures)


async def verify(name: str) -> Verified:
    """Measure one profile. Raises `LinkError`."""
    began_s = time.monotonic()
    profile = shortened(load(name))
    async with Link(profile) as link:
        server, browser = await asyncio.gather(
            _listen(link.server, link.browser), _listen(link.browser, link.server)
        )
        timetable = timetable_of(profile, time.monotonic() + 0.1)
        records = await asyncio.gather(
            _record(server, plan_of(profile.down, timetable)),
            _record(browser, plan_of(profile.up, timetable)),
            _change(link, timetable.full_s),
        )
        statistics = await link.statistics()
    down, up, _ = records
    seen = {"down": (down, up), "up": (up, down)}
    notes: list[str] = []
    figures: dict[WayName, list[Figure]] = {}
    for way in WAYS:
        sent, came = seen[way]
        judge = Judge(profile, way, timetable, start_s=link.start_s, sent=sent, came=came)
        figures[way] = judge.figures(notes)
    return Verified(name, time.monotonic() - began_s, figures, notes, statistics)


async def _listen(here: End, there: End) -> Process:
    """Start a probe; it listens on return."""
    arguments = ("-m", "e2e.link.probe", here.address, there.address)
    process = await here.spawn_python(arguments, stdin=PIPE, stdout=PIPE)
    assert process.stdout is not None
    await process.stdout.readline()
    return process


async def _record(probe: Process, plan: Plan) -> Record:
    out, _ = await probe.communicate(_PLAN.dump_json(plan))
    if probe.returncode != 0:
        raise LinkError("a probe of the link failed; its words are on standard error")
    return _RECORD.validate_json(out)


async def _change(link: Link, at_s: float) -> None:
    await asyncio.sleep(at_s - time.monotonic())
    await link.start_changes()
