"""Cross traffic on the same bottleneck, and recorded traces: what one viewer gets."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from tests.ablation.links import beside_download, beside_viewer, measured, recorded
from tests.link.trace import TraceTransmitter, read
from tests.sync.link_model import Loop

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

_RATES_BPS = (1_000_000, 3_000_000, 10_000_000)
_THIN_BPS = (400_000, 800_000, 2_000_000)
_BEGIN_S, _END_S, _RUN_S = 10.0, 40.0, 70.0


def cross_traffic(seed: int = 1) -> dict[str, list[dict[str, object]]]:
    """Measure shares, delay and starvation next to a download, and next to a second viewer."""
    return {
        "download": [_download(rate_bps, seed) for rate_bps in _RATES_BPS],
        "viewer": [_viewer(rate_bps, seed) for rate_bps in _THIN_BPS],
    }


def over_traces(paths: Sequence[Path], seconds: float = 60.0) -> list[dict[str, object]]:
    """Measure what each recorded trace carries to a viewer who drives."""
    files = [
        file
        for path in paths
        for file in (sorted(path.glob("*.down")) if path.is_dir() else [path])
    ]
    out: list[dict[str, object]] = []
    for file in files:
        link = recorded(file)
        loop = Loop(link, feedback_s=0.05)
        loop.run(seconds)
        mean_bps = round(TraceTransmitter(read(str(file)), 0.0).mean_bps)
        out.append({"trace": file.name, "mean_bps": mean_bps} | _rounded(loop, 5.0, seconds))
    return out


def rate_bps(loop: Loop, from_s: float, until_s: float) -> float:
    """Return the rate that a viewer received; times count from its own start."""
    came = sum(size for at_s, size in loop.record.came_bytes if from_s <= at_s < until_s)
    return 8 * came / (until_s - from_s)


def starved_s(loop: Loop, from_s: float, until_s: float) -> float:
    """Return for how long in all no picture was shown for a second or more."""
    shown = [from_s, *(at_s for at_s, _ in loop.record.shown if from_s <= at_s < until_s), until_s]
    shown.sort()
    gaps = [later - at for at, later in pairwise(shown)]
    return sum(gap for gap in gaps if gap >= 1.0)


def _download(link_bps: int, seed: int) -> dict[str, object]:
    loop, download = beside_download(
        seed, rate_bps=link_bps, begin_s=_BEGIN_S, end_s=_END_S, run_s=_RUN_S
    )
    during = (_BEGIN_S + 5, _END_S)
    return {
        "link_bps": link_bps,
        "alone_bps": round(rate_bps(loop, 4.0, _BEGIN_S)),
        "beside_bps": round(rate_bps(loop, *during)),
        "download_bps": round(download.rate_bps(*(loop.start_s + at_s for at_s in during))),
        "after_bps": round(rate_bps(loop, _END_S + 10, _RUN_S)),
        "starved_s": round(starved_s(loop, *during), 1),
        "starved_after_s": round(starved_s(loop, _END_S + 5, _RUN_S), 1),
    } | _rounded(loop, *during)


def _viewer(link_bps: int, seed: int) -> dict[str, object]:
    first, second = beside_viewer(seed, rate_bps=link_bps, begin_s=_BEGIN_S, run_s=_RUN_S)
    both = [rate_bps(first, 20.0, _RUN_S), rate_bps(second, 20.0 - _BEGIN_S, _RUN_S - _BEGIN_S)]
    return {
        "link_bps": link_bps,
        "first_bps": round(both[0]),
        "second_bps": round(both[1]),
        "fairness": round(sum(both) ** 2 / (2 * sum(one**2 for one in both)), 3),
        "starved_s": round(starved_s(first, 20.0, _RUN_S), 1),
        "second_starved_s": round(starved_s(second, 20.0 - _BEGIN_S, _RUN_S - _BEGIN_S), 1),
    } | _rounded(first, 20.0, _RUN_S)


def _rounded(loop: Loop, from_s: float, until_s: float) -> dict[str, object]:
    found = measured(loop, from_s, until_s, float("inf"))
    return {
        "bps": round(rate_bps(loop, from_s, until_s)),
        "picture_ms": None if found.picture_ms is None else round(found.picture_ms),
        "sound_ms": None if found.sound_ms is None else round(found.sound_ms),
        "concealed": round(found.concealed, 4),
    }
