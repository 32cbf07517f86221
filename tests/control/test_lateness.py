"""How late the ticks were, as a histogram."""

from __future__ import annotations

import pytest

from wax.control.lateness import BOUNDS_MS, Lateness


def test_lateness_falls_into_its_bucket() -> None:
    """Each bucket includes its bound, and the last one counts everything beyond."""
    lateness = Lateness()
    for bound_ms in BOUNDS_MS:
        lateness.add(bound_ms / 1000)
    lateness.add(10.0)
    assert lateness.counts == [1] * (len(BOUNDS_MS) + 1)
    assert lateness.sum_s == pytest.approx(sum(BOUNDS_MS) / 1000 + 10)
