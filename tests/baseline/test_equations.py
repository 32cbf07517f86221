"""Equations (3.1) to (3.4) of the thesis, at and between their boundaries."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.baseline.equations import hold_back_s, pictures_to_cache

lengths = st.tuples(st.integers(1, 500), st.integers(1, 20)).map(lambda ab: (ab[0] * ab[1], ab[0]))


@pytest.mark.parametrize(
    ("audio_mu_ms", "transfer_ms", "pictures"),
    [
        (500, 0.0, 4),  # the thesis's own example of (3.2)
        (500, 99.999, 4),
        (500, 100.0, 4),  # T_r = V, under (3.3)
        (500, 100.001, 3),
        (500, 125.0, 3),
        (500, 125.001, 2),
        (500, 249.0, 1),
        (500, 250.0, 1),
        (500, 250.001, 0),
        (500, 499.999, 0),
        (500, 500.0, 0),  # T_r = A, under (3.4)
        (500, 1e9, 0),
        (300, 0.0, 2),  # "if an audio MU is 300 ms and video MU is 100 ms, then two" (3.3.3.2)
        (400, 200.0, 1),  # not the two of 3.3.4
        (100, 0.0, 0),
        (100, 100.0, 0),
    ],
)
def test_the_cache_at_the_boundaries(audio_mu_ms: int, transfer_ms: float, pictures: int) -> None:
    """N_v is what (3.2), (3.3) and (3.4) give, rounded down, where they begin and end."""
    assert pictures_to_cache(transfer_ms, audio_mu_ms=audio_mu_ms, video_mu_ms=100) == pictures


@given(lengths, st.floats(0, 1e6))
def test_the_cached_pictures_and_one_more_fit_into_an_audio_mu(
    audio_and_video: tuple[int, int], transfer_ms: float
) -> None:
    """If any picture is cached, N_v + 1 get through within A, and N_v + 2 do not."""
    audio_mu_ms, video_mu_ms = audio_and_video
    cached = pictures_to_cache(transfer_ms, audio_mu_ms=audio_mu_ms, video_mu_ms=video_mu_ms)
    pace_ms = max(transfer_ms, video_mu_ms)
    assert 0 <= cached <= audio_mu_ms // video_mu_ms - 1
    if transfer_ms < audio_mu_ms:
        assert (cached + 1) * pace_ms <= audio_mu_ms * (1 + 1e-12)
        assert (cached + 2) * pace_ms > audio_mu_ms * (1 - 1e-12)


@given(lengths, st.floats(0, 1e6), st.floats(0, 1e6))
def test_a_slower_link_never_caches_more(
    audio_and_video: tuple[int, int], one_ms: float, other_ms: float
) -> None:
    """N_v does not grow with T_r."""
    audio_mu_ms, video_mu_ms = audio_and_video
    fast, slow = (
        pictures_to_cache(transfer_ms, audio_mu_ms=audio_mu_ms, video_mu_ms=video_mu_ms)
        for transfer_ms in sorted((one_ms, other_ms))
    )
    assert slow <= fast


@pytest.mark.parametrize(
    ("transfer_ms", "audio_mu_ms", "video_mu_ms"),
    [(-1.0, 500, 100), (math.nan, 500, 100), (10.0, 450, 100), (10.0, 0, 100), (10.0, 100, 0)],
)
def test_what_is_no_time_is_refused(transfer_ms: float, audio_mu_ms: int, video_mu_ms: int) -> None:
    """A negative time, or an audio MU that is no whole multiple of the video MU, raises."""
    with pytest.raises(ValueError, match=r"multiple|negative"):
        pictures_to_cache(transfer_ms, audio_mu_ms=audio_mu_ms, video_mu_ms=video_mu_ms)


def test_the_hold_back_is_the_difference_of_the_timestamps() -> None:
    """T_p is T_v2 less T_a1 (3.1), and 0 for sound that is younger than the picture."""
    assert hold_back_s(10.0, 10.4) == pytest.approx(0.4)
    assert hold_back_s(10.0, 10.0) == 0.0
    assert hold_back_s(10.4, 10.0) == 0.0
