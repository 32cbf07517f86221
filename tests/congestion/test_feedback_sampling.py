"""Which packets request feedback: all while it matters, samples otherwise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.congestion.control import LinkEstimate
from wax.congestion.feedback import FeedbackSampling

if TYPE_CHECKING:
    from wax.congestion.control import LinkState


def _estimate(
    state: LinkState = "steady", rate_bps: float = 5e6, used_bps: float = 1e6, queue_ms: float = 0.0
) -> LinkEstimate:
    return LinkEstimate(
        state=state,
        rate_bps=rate_bps,
        used_bps=used_bps,
        queue_ms=queue_ms,
        jitter_ms=0.0,
        lost=0.0,
        burst=0,
        round_trip_ms=20.0,
    )


def _marked(
    sampling: FeedbackSampling, seconds: float, pictures_hz: float | None = 30.0
) -> list[str]:
    """Send sound each 20 ms, and pictures of three packets; return which were marked."""
    found, train, next_s = [], 0, 0.0
    for tick in range(round(seconds * 50)):
        now_s = 100 + tick / 50
        if sampling.requests_feedback(None, now_s):
            found.append("sound")
        if pictures_hz is not None and tick / 50 >= next_s:
            next_s += 1 / pictures_hz
            train += 1
            kinds = {sampling.requests_feedback(train, now_s + part * 0.03) for part in range(3)}
            assert len(kinds) == 1, "a picture is marked whole or not at all"
            found += ["picture"] * kinds.pop()
    return found


@pytest.mark.parametrize(
    ("estimate", "full_feedback"),
    [
        (_estimate("starting"), False),
        (_estimate("congested"), False),
        (_estimate("congested", rate_bps=40_000.0), True),
        (_estimate("blind"), False),
        (_estimate(queue_ms=80.0), False),
        (_estimate(used_bps=4e6), False),
        (_estimate(), True),
    ],
)
def test_all_is_marked_while_it_matters(estimate: LinkEstimate, full_feedback: bool) -> None:
    """Every packet requests feedback at startup, under congestion, and for the operator."""
    sampling = FeedbackSampling()
    sampling.choose_interval(estimate, full_feedback=full_feedback)
    assert not sampling.is_sparse
    marked = _marked(sampling, 2.0)
    assert marked.count("sound") == 100
    assert marked.count("picture") >= 59


def test_who_only_watches_tells_of_samples() -> None:
    """On a settled link an observer's browser sends two or three feedback packets a second."""
    sampling = FeedbackSampling()
    sampling.choose_interval(_estimate(), full_feedback=False)
    assert sampling.is_sparse
    assert 9 <= _marked(sampling, 4.0).count("picture") <= 22


@pytest.mark.parametrize("full_feedback", [True, False])
def test_a_thin_uplink_is_spared(full_feedback: bool) -> None:
    """On a modem line feedback comes twice a second, for everybody."""
    sampling = FeedbackSampling()
    sampling.choose_interval(
        _estimate(rate_bps=48_000.0, used_bps=46_000.0), full_feedback=full_feedback
    )
    marked = _marked(sampling, 10.0, pictures_hz=10.0)
    assert 15 <= marked.count("picture") <= 22
    assert marked.count("sound") <= 40


def test_sound_alone_is_heard_of_too() -> None:
    """Without a picture the sound's packets are sampled."""
    sampling = FeedbackSampling()
    sampling.choose_interval(_estimate(rate_bps=48_000.0), full_feedback=False)
    assert 8 <= _marked(sampling, 10.0, pictures_hz=None).count("sound") <= 25
