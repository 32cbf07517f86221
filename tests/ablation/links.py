"""The links of the ablation, and the measures on each."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from random import Random
from typing import TYPE_CHECKING, Any, Final

from tests.congestion.bottleneck import Port, TcpDownload, bottleneck, run
from tests.link.profile import Profile
from tests.sync.link_model import Loop, profile

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from wax.congestion.allocation import Allocation, Step

_START_S: Final = 100.0
_BURST: Final = {"in_bad": 0.8, "good_to_bad": 0.0133, "bad_to_good": 0.3333}
_TOP_BPS: Final = 1_120_000
"""Rate of the largest rendition with its sound; no link is ever used beyond it."""


@dataclass(frozen=True, slots=True)
class Measures:
    """The measures of one viewer on one link, after the startup.

    `use` is what arrived, as a fraction (0 to 1) of what the link carries or the best rendition
    takes. The ages are the 95th percentiles for the shown pictures and for the sound's packets;
    `concealed` is a share of the sound. `recovery_s` counts from the end of a disturbance until the
    previous rendition is back, or the run ends. None if there is nothing to measure.
    """

    use: float
    picture_ms: float | None
    sound_ms: float | None
    concealed: float
    recovery_s: float | None = None

    def as_dict(self) -> dict[str, float | None]:
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Case:
    """One link: how long it runs, and when its disturbance begins and ends."""

    measure: Callable[[int], Measures]
    about: str


def network(about: str, **down: Any) -> Profile:
    """Return a link whose return path is fast and has the same delay."""
    up = {"rate_bps": 5_000_000, "queue_ms": 500.0, "delay_ms": down["delay_ms"]}
    if outages := [change for change in down.get("changes", ()) if "outage" in change]:
        up["changes"] = outages
    return Profile.model_validate({"about": about, "down": down, "up": up})


def cellular(seed: int = 7, seconds: int = 60) -> Profile:
    """Return a synthetic cell: a rate that walks from 0.15 to 6 Mbit/s five times a second."""
    random, rate_bps = Random(f"{seed} cellular"), 2e6
    changes = []
    for tick in range(1, seconds * 5):
        rate_bps = min(max(rate_bps * math.exp(random.gauss(0, 0.25)), 150e3), 6e6)
        changes.append({"at_s": tick / 5, "rate_bps": round(rate_bps)})
    return network(
        "a synthetic cell", rate_bps=2_000_000, queue_ms=1000.0, delay_ms=30.0, changes=changes
    )


def carried_bps(cell: Profile, from_s: float, until_s: float) -> float:
    """Return the average share of the best rendition that a cell carries in this time."""
    changes = cell.down.changes
    rates = [change.rate_bps or 0 for change in changes if from_s <= change.at_s < until_s]
    return sum(min(rate_bps, _TOP_BPS) for rate_bps in rates) / len(rates)


def repeated_outages(rate_bps: int = 400_000, seconds: int = 130) -> Profile:
    """Return a thin link that loses everything, both ways, for 2 s in each 20."""
    changes = [
        {"at_s": float(at_s + shift), "loss": {"in_good": 1.0 if shift == 0 else 0.0}}
        for at_s in range(20, seconds, 20)
        for shift in (0, 2)
    ]
    way = {"rate_bps": rate_bps, "queue_ms": 500.0, "delay_ms": 25.0, "changes": changes}
    about = "400 kbit/s, nothing comes for 2 s in each 20"
    return Profile.model_validate({"about": about, "down": way, "up": way})


def burst_loss() -> Profile:
    """Return a link of 8 Mbit/s that loses 3 % of the packets in bursts."""
    return network(
        "8 Mbit/s, 3 % lost in bursts",
        rate_bps=8_000_000,
        queue_ms=500.0,
        delay_ms=25.0,
        loss=_BURST,
    )


def long_outage() -> Profile:
    """Return a link of 2 Mbit/s that is cut from 8 s to 12 s."""
    changes = [{"at_s": 8.0, "outage": True}, {"at_s": 12.0, "outage": False}]
    return network(
        "cut for 4 s", rate_bps=2_000_000, queue_ms=500.0, delay_ms=25.0, changes=changes
    )


def longer_route() -> Profile:
    """Return a link of 2 Mbit/s whose route takes 80 ms more from 6 s on."""
    changes = [{"at_s": 6.0, "delay_ms": 105.0}]
    return network(
        "a longer route", rate_bps=2_000_000, queue_ms=500.0, delay_ms=25.0, changes=changes
    )


def shared(rate_bps: int) -> Profile:
    """Return a bottleneck with a queue of 300 ms."""
    return network("shared", rate_bps=rate_bps, queue_ms=300.0, delay_ms=20.0)


def recorded(path: Path) -> Profile:
    """Return a link that follows a trace in the format of mahimahi."""
    return network(path.name, trace=str(path), queue_ms=500.0, delay_ms=25.0)


def measured(
    loop: Loop,
    from_s: float,
    until_s: float,
    carries_bps: float,
    *,
    before_s: float | None = None,
    after_s: float | None = None,
) -> Measures:
    """Sum up a run; `before_s` is when the rendition was right, `after_s` when it could return."""
    record = loop.record
    came = sum(size for at_s, size in record.came_bytes if from_s <= at_s < until_s)
    ages = sorted(age_s for at_s, age_s in record.shown if from_s <= at_s < until_s)
    sounds = sorted(age_s for at_s, age_s in record.sounds if from_s <= at_s < until_s)
    played = [row for row in record.played if from_s <= row[0] <= until_s]
    concealed_s, played_s = played[-1][1] - played[0][1], played[-1][2] - played[0][2]
    recovery_s = None
    if before_s is not None and after_s is not None:
        wanted = _bitrate(record.at(before_s).step)
        below_s = [
            at_s
            for at_s, is_below in _changes(record.allocations, wanted, until_s)
            if at_s > after_s and not is_below
        ]
        recovery_s = max(below_s, default=after_s) - after_s
    return Measures(
        use=8 * came / (until_s - from_s) / min(carries_bps, _TOP_BPS),
        picture_ms=1000 * ages[int(0.95 * (len(ages) - 1))] if ages else None,
        sound_ms=1000 * sounds[int(0.95 * (len(sounds) - 1))] if sounds else None,
        concealed=concealed_s / played_s if played_s else 1.0,
        recovery_s=recovery_s,
    )


def _changes(
    allocations: list[tuple[float, Allocation]], wanted_bps: int, until_s: float
) -> list[tuple[float, bool]]:
    """Return when the rendition fell below the wanted one and rose again, up to `until_s`."""
    out, is_below = [], False
    for at_s, allocation in [*allocations, (until_s, None)]:
        below = allocation is not None and _bitrate(allocation.step) < wanted_bps
        if below != is_below:
            out.append((at_s, below))
        is_below = below
    return out


def _bitrate(step: Step | None) -> int:
    return 0 if step is None else step.bitrate_bps


def _alone(
    network: Profile, seconds: float, carries_bps: float, *, drives: bool = False, **more: Any
) -> Callable[[int], Measures]:
    def measure(seed: int) -> Measures:
        loop = Loop(network, feedback_s=0.05, seed=seed, drives=drives)
        loop.run(seconds)
        return measured(loop, 4.0, seconds, carries_bps, **more)

    return measure


def _another_cell(seed: int) -> Measures:
    cell = cellular(seed)
    return _alone(cell, 25, carried_bps(cell, 4.0, 25.0), drives=True)(seed)


def _by_loss_alone(seed: int) -> Measures:
    loop = Loop(profile("wireless-1m", queue_ms=200.0), has_feedback=False, seed=seed)
    loop.run(20)
    return measured(loop, 4.0, 20.0, 1e6)


def beside_download(
    seed: int,
    *,
    rate_bps: int = 3_000_000,
    begin_s: float = 6.0,
    end_s: float = 12.0,
    run_s: float = 24.0,
) -> tuple[Loop, TcpDownload]:
    """Run a viewer whose bottleneck carries a download of CUBIC for a while."""
    link = shared(rate_bps)
    pipe = bottleneck(link, seed=seed, start_s=_START_S)
    loop = Loop(link, down=Port(pipe), feedback_s=0.05, seed=seed)
    download = TcpDownload(
        Port(pipe), back_s=0.02, begin_s=_START_S + begin_s, end_s=_START_S + end_s
    )
    run([loop, download], _START_S + run_s)
    return loop, download


def beside_viewer(
    seed: int, *, rate_bps: int = 800_000, begin_s: float = 5.0, run_s: float = 25.0
) -> tuple[Loop, Loop]:
    """Run two viewers over one bottleneck; the second joins later."""
    link = shared(rate_bps)
    pipe = bottleneck(link, seed=seed, start_s=_START_S)
    first = Loop(link, down=Port(pipe), feedback_s=0.05, seed=seed)
    second = Loop(
        link, down=Port(pipe), feedback_s=0.05, seed=seed + 100, start_s=_START_S + begin_s
    )
    run([first, second], _START_S + run_s)
    return first, second


def _download(seed: int) -> Measures:
    loop, _ = beside_download(seed)
    return measured(loop, 6.0, 24.0, 3e6, before_s=5.5, after_s=12.0)


CASES: Final = {
    "modem": Case(_alone(profile("modem-56k"), 30, 50e3), "56k modem"),
    "wireless": Case(_alone(profile("wireless-1m"), 15, 1e6, drives=True), "1 Mbit/s, stalls"),
    "lte-edge": Case(_alone(profile("lte-edge"), 12, 1.5e6, drives=True), "1.5 Mbit/s, stalls"),
    "wifi-bad": Case(_alone(profile("wifi-bad"), 12, 10e6), "10 Mbit/s, 5 % lost in bursts"),
    "bursts": Case(_alone(burst_loss(), 12, 8e6), "8 Mbit/s, 3 % lost in bursts"),
    "step-down": Case(
        _alone(profile("step-down"), 16, 5e6, drives=True, before_s=4.9, after_s=10.0),
        "5 Mbit/s, 0.3 from 5 to 10 s",
    ),
    "outages": Case(
        _alone(repeated_outages(), 45, 360e3, before_s=19.0, after_s=22.0),
        "400 kbit/s, nothing comes for 2 s in each 20",
    ),
    "long-outage": Case(
        _alone(long_outage(), 20, 2e6, before_s=7.9, after_s=12.0), "2 Mbit/s, cut for 4 s"
    ),
    "cellular": Case(
        _alone(cellular(), 25, carried_bps(cellular(), 4.0, 25.0), drives=True), "a rate that walks"
    ),
    "cells": Case(_another_cell, "such a rate, another one for each seed"),
    "route": Case(
        _alone(longer_route(), 14, 2e6, before_s=5.9, after_s=6.0), "80 ms more from 6 s on"
    ),
    "satellite": Case(_alone(profile("satellite"), 12, 10e6), "600 ms there and back"),
    "short-queue": Case(
        _alone(profile("wireless-2m", rate_bps=400_000, queue_ms=60.0), 20, 400e3, drives=True),
        "400 kbit/s, 60 ms of queue",
    ),
    "download": Case(_download, "3 Mbit/s, a download from 6 to 12 s"),
    "loss-only": Case(_by_loss_alone, "1 Mbit/s, no transport-wide feedback"),
}
