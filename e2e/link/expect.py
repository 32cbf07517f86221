"""What a profile promises in figures, and how far a sample may be from it by chance; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tests.link.chance import jitter_quantile_ms

if TYPE_CHECKING:
    from tests.link.profile import Jitter, Loss

SHARE: Final = 0.05
"""A measured figure may be off by this much of what is promised,"""
FLOOR_MS: Final = 0.5
"""a time by this much in any case,"""
DEVIATIONS: Final = 3.3
"""and what is drawn by chance by so many standard errors of the sample (999 of 1000 samples)."""

_LOW, _MIDDLE, _HIGH = 0.1, 0.5, 0.9


@dataclass(frozen=True, slots=True)
class Figure:
    """One measured against one promised."""

    name: str
    promised: float
    measured: float
    allowed: float
    """How far measured may be from promised."""

    @property
    def ok(self) -> bool:
        return abs(self.measured - self.promised) <= self.allowed


def time_figure(name: str, promised_ms: float, measured_ms: float, error_ms: float) -> Figure:
    """Judge a time; `error_ms` is the sample's standard error."""
    allowed_ms = max(SHARE * promised_ms, FLOOR_MS, DEVIATIONS * error_ms)
    return Figure(name, promised_ms, measured_ms, allowed_ms)


def delay_figure(base_ms: float, jitter: Jitter | None, delays_ms: list[float]) -> Figure:
    """Judge the median of the delays; `base_ms` is what they are without jitter."""
    promised_ms = base_ms + jitter_quantile_ms(jitter, _MIDDLE)
    error_ms = _slope_ms(jitter, _MIDDLE) * math.sqrt(0.25 / len(delays_ms))
    return time_figure("delay_ms", promised_ms, quantile(delays_ms, _MIDDLE), error_ms)


def jitter_figure(jitter: Jitter | None, delays_ms: list[float]) -> Figure:
    """Judge the spread of the delays, from their 10 % to their 90 % quantile."""
    low, high = _slope_ms(jitter, _LOW), _slope_ms(jitter, _HIGH)
    # Covariance of two sample quantiles p < q: p (1 − q) / (n f(p) f(q)); a slope is 1 / f.
    variance = (low**2 * _LOW * (1 - _LOW) + high**2 * _HIGH * (1 - _HIGH)) / len(delays_ms)
    variance -= 2 * low * high * _LOW * (1 - _HIGH) / len(delays_ms)
    return time_figure(
        "jitter_ms",
        jitter_quantile_ms(jitter, _HIGH) - jitter_quantile_ms(jitter, _LOW),
        quantile(delays_ms, _HIGH) - quantile(delays_ms, _LOW),
        math.sqrt(max(0.0, variance)),
    )


def loss_figure(loss: Loss, sent: int, came: int) -> Figure:
    """Judge the share of packets that did not come."""
    mean = loss.mean
    # Neighbours are alike where losses come in bursts, so the sample is worth less.
    alike = max(0.0, 1 - loss.good_to_bad - loss.bad_to_good)
    error = math.sqrt(mean * (1 - mean) / sent * (1 + alike) / (1 - alike))
    return Figure("loss", mean, 1 - came / sent, max(SHARE * mean, DEVIATIONS * error))


def rate_bps(arrivals: list[tuple[float, int]]) -> float:
    """Return the rate of a full link from times and sizes, in the order of arrival.

    The median over pairs half the sample apart, which a stall or a burst does not move.
    """
    total, sums = 0, []
    for _, size_bytes in arrivals:
        total += size_bytes
        sums.append(total)
    half = len(arrivals) // 2
    slopes = [
        (sums[index + half] - sums[index]) * 8 / (arrivals[index + half][0] - arrivals[index][0])
        for index in range(len(arrivals) - half)
        if arrivals[index + half][0] > arrivals[index][0]
    ]
    return quantile(slopes, _MIDDLE) if half and slopes else 0.0


def quantile(values: list[float], share: float) -> float:
    """Return a quantile, interpolated; of nothing it is not a number."""
    if not values:
        return math.nan
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = math.floor(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def _slope_ms(jitter: Jitter | None, share: float) -> float:
    step = 0.01
    below, above = (jitter_quantile_ms(jitter, share + side) for side in (-step, step))
    return (above - below) / (2 * step)
