"""What viewers leave behind: nothing."""

from __future__ import annotations

import pytest
from e2e.load.crowd.crowd import gathered
from e2e.load.memory import BATCHES, FLAT_MIB, come_and_go
from e2e.load.servers import WAX, serving
from e2e.strangers.soak import Sample, Soaked, rows, soak


@pytest.mark.system
@pytest.mark.timeout(240)
async def test_half_a_minute_of_coming_and_going_leaves_nothing() -> None:
    """Threads, descriptors and tasks are as many as before, while somebody drove throughout."""
    found = await soak(30.0)
    assert found.joins >= 10
    assert len(found.samples) >= 10
    assert found.left == 0


@pytest.mark.system
@pytest.mark.full
@pytest.mark.timeout(1800)
async def test_a_thousand_who_joined_and_left_leave_nothing() -> None:
    """No thread, descriptor or task, and no memory."""
    async with serving(WAX) as server, gathered(server.offering) as crowd:
        leaked_mib, left = await come_and_go(server, crowd, 1000 // BATCHES)
    assert left == 0
    assert leaked_mib <= FLAT_MIB


def _soaked(last_mib: float, last_ms: float | None, *, left: int = 0, stops: int = 0) -> Soaked:
    samples = [
        Sample(at=n / 600, rss_mib=100.0, sound_ms=50.0, picture_ms=20.0, trip_ms=1.0)
        for n in range(500)
    ]
    samples += [Sample(n / 600, last_mib, last_ms, 20.0, 1.0) for n in range(500, 600)]
    return Soaked(1800.0, samples, ["no reason"] * stops, 120, left)


def test_what_has_not_grown_is_met() -> None:
    """Two MiB and five milliseconds are within what a machine's own unrest explains."""
    assert all(row.met for row in rows(_soaked(102.0, 55.0)))


@pytest.mark.parametrize(
    ("found", "missed"),
    [
        (_soaked(102.1, 50.0), "soak: memory"),
        (_soaked(100.0, 55.1), "soak: delay"),
        (_soaked(100.0, 50.0, left=1), "soak: left"),
        (_soaked(100.0, 50.0, stops=1), "soak: stops"),
    ],
)
def test_what_grows_or_is_left_is_missed(found: Soaked, missed: str) -> None:
    """Each goal is judged by itself."""
    assert [row.key for row in rows(found) if not row.met] == [missed]
