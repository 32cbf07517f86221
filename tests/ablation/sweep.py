"""Runs the links with each constant halved and doubled, and reports the changes."""

from __future__ import annotations

import json
import math
import os
import statistics
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from e2e.measure.suite import digest
from tests.ablation.constants import Constant, constants
from tests.ablation.links import CASES

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

Result = dict[str, dict[str, float | None]]
"""By link and then by measure."""

FACTORS: Final = {"half": 0.5, "double": 2.0}
FACTS: Final = {
    "wire_cost.UDP_IP_BYTES",
    "estimator._MAX_CLOCK_S",
    "estimator._MAX_DATAGRAM_BYTES",
    "wire_cost._BLOCK_BYTES",
    "wire_cost._HEADER_BYTES",
    "wire_cost._LAYER_SHARE",
}
"""Fixed by the wire, the codec or floating point, and therefore not ours to choose."""
BOUNDS: Final = {
    "delivery_rate._MAX_PACKETS",
    "delivery_rate._MAX_DISPERSION_S",
    "delivery_rate._MAX_TRAINS",
    "estimator._MAX_DELIVERY_AGE_S",
    "feedback._MAX_ROUND_TRIP_S",
    "hold_back._FARTHEST_MS",
    "queuing_delay.MAX_MS",
    "queuing_delay._MAX_JITTER_PACKETS",
    "loss._BURSTS",
    "queuing_delay._MAX_RECENT_PACKETS",
    "send_history._KEPT_PACKETS",
    "upload_budget._REPEAT_SHARE",
}
"""Bounds for memory, for all links together, or for invalid input, which no link here reaches."""
ELSEWHERE: Final = {
    "estimator._REPORTS",
    "late_encoding._LATE_S",
    "late_encoding._LATE_SHARE",
    "late_encoding._MAX_PAUSE_S",
    "late_encoding._PAUSE_S",
    "late_encoding._TRIAL_S",
    "late_loop._CUT",
    "late_loop._LATE_S",
    "late_loop._LEAST_BPS",
    "late_loop._ON_TIME_S",
    "late_loop._STEP",
}
"""Used only without feedback on the sound's packets, or on a machine that is late: none here is."""

MEASURES: Final = ("server/wax/congestion/*.py", "server/wax/sync/*.py")
_HARNESS: Final = (
    "server/wax/rtc/picture_sender.py",
    "server/wax/rtc/retransmissions.py",
    "tests/ablation/links.py",
    "tests/congestion/bottleneck.py",
    "tests/link/*.py",
    "tests/sync/*_model.py",
)
_SEEDS: Final = 6
"""Runs of each value: their means are compared, and their spread is the effect of chance."""
_NOTICEABLE: Final = {
    "use": (0.04, 0.0),
    "picture_ms": (15.0, 0.10),
    "sound_ms": (8.0, 0.10),
    "concealed": (0.005, 0.0),
    "recovery_s": (1.0, 0.10),
}
"""The smallest change of each measure to mention: the larger of absolute and relative."""


def tuned() -> list[Constant]:
    """Return the constants that are tuned."""
    return [one for one in constants() if one.key not in FACTS | BOUNDS | ELSEWHERE]


def run(seed: int = 1) -> Result:
    """Measure every link with the constants as they are."""
    return {name: case.measure(seed).as_dict() for name, case in CASES.items()}


def run_with(key: str, factor: float) -> Result:
    """Measure the means with one constant changed; return nothing if the value makes no sense."""
    (constant,) = [one for one in constants() if one.key == key]
    with constant.set(constant.scaled(factor)), suppress(ArithmeticError):
        return means([run(seed) for seed in range(1, _SEEDS + 1)])
    return {}


def base(found: dict[str, Result]) -> Result:
    """Return the means of all seeds with the constants as they are."""
    return means([found[f"seed {seed}"] for seed in range(1, _SEEDS + 1)])


def means(runs: list[Result]) -> Result:
    """Return the mean of each measure over the runs that have it."""
    out: Result = {}
    for link, measures in runs[0].items():
        out[link] = {}
        for measure in measures:
            known = [value for one in runs if (value := one[link][measure]) is not None]
            out[link][measure] = statistics.fmean(known) if known else None
    return out


def sweep(path: Path, jobs: int) -> dict[str, Result]:
    """Measure whatever lacks a result in `path` for this code; return all, by key and factor."""
    mine = digest([*MEASURES, *_HARNESS])
    found = _read(path, mine)
    path.parent.mkdir(parents=True, exist_ok=True)
    wanted = [name for name in _names() if name not in found]
    with ProcessPoolExecutor(jobs) as pool, path.open("a", encoding="utf-8") as file:
        futures = {pool.submit(_one, name): name for name in wanted}
        for future in as_completed(futures):
            name, result = futures[future], future.result()
            found[name] = result
            file.write(json.dumps({"code": mine, "name": name, "result": result}) + "\n")
            file.flush()
    return {name: found[name] for name in _names()}


def effect(before: Result, after: Result, spread: Result) -> str:
    """Describe the largest change over all links and measures."""
    if not after:
        return "makes no sense"
    worst, said = 1.0, ""
    same = True
    for link, measures in before.items():
        for measure, was in measures.items():
            now = after[link][measure]
            same = same and was == now
            if was is None or now is None:
                if was is not now and worst < 3:
                    worst, said = 3.0, f"{link}: {_WORDS[measure]} {_say(measure, was, now)}"
                continue
            least, share = _NOTICEABLE[measure]
            noticeable = max(least, share * abs(was), spread[link][measure] or 0.0)
            if abs(now - was) / noticeable > worst:
                worst = abs(now - was) / noticeable
                said = f"{link}: {_WORDS[measure]} {_say(measure, was, now)}"
    return said or ("the same" if same else "no change to speak of")


def spread(found: dict[str, Result]) -> Result:
    """Return how much chance alone changes each measure (standard deviation over seeds)."""
    out: Result = {}
    for link, measures in found["seed 1"].items():
        out[link] = {}
        for measure in measures:
            values = [found[f"seed {seed}"][link][measure] for seed in range(1, _SEEDS + 1)]
            known = [value for value in values if value is not None]
            out[link][measure] = statistics.stdev(known) if len(known) > 1 else 0.0
    return out


_WORDS: Final = {
    "use": "use",
    "picture_ms": "picture",
    "sound_ms": "sound",
    "concealed": "concealed",
    "recovery_s": "recovery",
}


def _say(measure: str, was: float | None, now: float | None) -> str:
    return f"{_figure(measure, was)} → {_figure(measure, now)}"


def _figure(measure: str, value: float | None) -> str:
    if value is None:
        return "none"
    if measure in ("use", "concealed"):
        return f"{100 * value:.{0 if measure == 'use' else 1}f} %"
    return f"{value:.0f} ms" if measure.endswith("_ms") else f"{value:.1f} s"


def mean(result: Result, measure: str) -> float | None:
    """Return the mean over the links that have this measure."""
    values = [one[measure] for one in result.values()]
    known = [value for value in values if value is not None and math.isfinite(value)]
    return statistics.fmean(known) if known else None


def _names() -> Iterator[str]:
    for seed in range(1, _SEEDS + 1):
        yield f"seed {seed}"
    for constant in tuned():
        for factor in FACTORS:
            yield f"{constant.key} {factor}"


def _one(name: str) -> Result:
    key, _, last = name.rpartition(" ")
    return run(int(last)) if key == "seed" else run_with(key, FACTORS[last])


def _read(path: Path, mine: str) -> dict[str, Result]:
    if not path.exists():
        return {}
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return {line["name"]: line["result"] for line in lines if line["code"] == mine}


def default_jobs() -> int:
    return max(1, os.cpu_count() or 1)
