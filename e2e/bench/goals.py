"""The goals beside what was measured; a missed one is told, not raised."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Collection

    from e2e.bench.fanout import FanOut
    from e2e.bench.first_picture import FirstPicture
    from e2e.bench.key_to_byte import KeyToByte
    from e2e.bench.memory import Churn, MemoryUse

T = TypeVar("T")

FLAT_MIB = 2.0
"""Growth over all join/leave cycles that still counts as flat: the allocator's own unrest."""


@dataclass(slots=True)
class Sides(Generic[T]):
    """The same measurement on both; None where it was not made."""

    ours: T | None = None
    stock: T | None = None


@dataclass(slots=True)
class Results:
    """All that one run measured."""

    fanout: Sides[FanOut]
    first_picture: Sides[FirstPicture]
    key_to_byte: Sides[KeyToByte]
    memory: Sides[MemoryUse]


@dataclass(frozen=True, slots=True)
class Goal:
    """`met` is None when it was not measured; `stock` is the peer's figure where it has one."""

    name: str
    at_most: float
    unit: str
    result: float | None
    stock: float | None
    met: bool | None
    detail: str


def goals(results: Results, asked: Collection[str]) -> list[Goal]:
    """Judge the measurements that were asked for, whether or not they could be made."""
    judged = {
        "fanout": _fanout(results.fanout),
        "first_picture": _first_picture(results.first_picture),
        "key_to_byte": _key_to_byte(results.key_to_byte),
        "memory": _memory(results.memory),
    }
    return [goal for name in judged if name in asked for goal in judged[name]]


def _goal(
    name: str,
    at_most: float,
    result: float | None,
    *,
    unit: str = "",
    stock: float | None = None,
    detail: str = "",
) -> Goal:
    met = None if result is None else result <= at_most
    return Goal(name, at_most, unit, result, stock, met, detail)


def _fanout(sides: Sides[FanOut]) -> list[Goal]:
    return [_sixteen(sides), _further(sides), _fifty(sides)]


def _sixteen(sides: Sides[FanOut]) -> Goal:
    name = "server CPU, 16 viewers / stock's 8"
    ours = sides.ours.at(16) if sides.ours else None
    stock = sides.stock.at(8) if sides.stock else None
    if ours is None or stock is None:
        return _goal(name, 1 / 3, None)
    flaw = ours.flaw or stock.flaw
    if flaw is not None:
        return _goal(name, 1 / 3, None, detail=flaw)
    detail = (
        f"{ours.server_cpu:.3f} ± {ours.server_cpu_sd:.3f} of a core to "
        f"{stock.server_cpu:.3f} ± {stock.server_cpu_sd:.3f}"
    )
    return _goal(name, 1 / 3, ours.server_cpu / stock.server_cpu, detail=detail)


def _further(sides: Sides[FanOut]) -> Goal:
    name = "CPU of a further viewer / stock's"
    ours = sides.ours.cpu_per_further_viewer if sides.ours else None
    stock = sides.stock.cpu_per_further_viewer if sides.stock else None
    if ours is None or not stock:
        return _goal(name, 1 / 20, None)
    detail = f"{ours * 100:.2f} % of a core to {stock * 100:.2f} %"
    return _goal(name, 1 / 20, ours / stock, detail=detail)


def _fifty(sides: Sides[FanOut]) -> Goal:
    name = "packets dropped, 50 viewers on one core"
    point = sides.ours.at(50) if sides.ours else None
    if point is None:
        return _goal(name, 0, None)
    if point.flaw is not None:
        return _goal(name, 0, None, detail=point.flaw)
    server_drops = sum(point.server_drops.values())
    detail = (
        f"{point.packets_lost} gaps in {point.packets} packets, {server_drops:g} dropped by the "
        f"server; CPU {point.server_cpu:.2f}, slowest viewer {point.fps_min:.1f} fps"
    )
    return _goal(name, 0, point.packets_lost + server_drops, detail=detail)


def _first_picture(sides: Sides[FirstPicture]) -> list[Goal]:
    name = "first picture, median"
    if sides.ours is None:
        return [_goal(name, 500, None, unit="ms")]
    warm = sides.ours.warm_ms
    detail = f"n={warm.n}, {warm.min:.0f}–{warm.max:.0f}; new browser {sides.ours.cold_ms:.0f}"
    stock = sides.stock.warm_ms.p50 if sides.stock else None
    return [_goal(name, 500, warm.p50, unit="ms", stock=stock, detail=detail)]


def _key_to_byte(sides: Sides[KeyToByte]) -> list[Goal]:
    name = "key press to byte on the line, p99"
    if sides.ours is None:
        return [_goal(name, 25, None, unit="ms")]
    delay = sides.ours.press_ms
    detail = (
        f"n={delay.n}, p50 {delay.p50:.1f}, p95 {delay.p95:.1f}, max {delay.max:.1f}, "
        f"clocks ± {sides.ours.clock_error_ms:.2f}; {sides.ours.unanswered} unanswered"
    )
    return [_goal(name, 25, delay.p99, unit="ms", detail=detail)]


def _memory(sides: Sides[MemoryUse]) -> list[Goal]:
    ours, stock = sides.ours, sides.stock
    first = ours.points[0] if ours else None
    churn = ours.churn if ours else None
    left = None
    if churn is not None:
        left = (churn.handles_after.threads - churn.handles_before.threads) + (
            churn.handles_after.descriptors - churn.handles_before.descriptors
        )
        left += (churn.tasks_after or 0) - (churn.tasks_before or 0)
    tasks = "tasks counted" if churn and churn.tasks_after is not None else "tasks not told"
    return [
        _goal(
            "memory with one viewer, RSS",
            250,
            first.rss_mib if first else None,
            unit="MiB",
            stock=stock.points[0].rss_mib if stock else None,
            detail=f"USS {first.uss_mib:.0f} MiB" if first else "",
        ),
        _goal(
            "memory of a further viewer, RSS",
            2,
            ours.rss_mib_per_further_viewer if ours else None,
            unit="MiB",
            stock=stock.rss_mib_per_further_viewer if stock else None,
            detail=f"USS {ours.uss_mib_per_further_viewer:.2f} MiB" if ours else "",
        ),
        _goal(
            "memory leaked by all join/leave cycles",
            FLAT_MIB,
            _leaked_mib(churn) if churn else None,
            unit="MiB",
            stock=_leaked_mib(stock.churn) if stock else None,
            detail=(
                f"n={churn.cycles}, {churn.rss_kib_per_cycle:.1f} KiB a cycle once warm; "
                f"RSS {churn.rss_before_mib:.0f} → {churn.rss_after_mib:.0f} MiB"
            )
            if churn
            else "",
        ),
        _goal("tasks, threads, descriptors left by them", 0, left, detail=tasks if churn else ""),
    ]


def _leaked_mib(churn: Churn) -> float:
    return churn.rss_kib_per_cycle * churn.cycles / 1024
