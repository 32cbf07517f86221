"""The statistics by which trainers normalise a dataset, against those of all its values."""

from __future__ import annotations

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from wax.dataset.statistics import PictureStatistics, merged, of_rows

VALUES = arrays.arrays(
    np.float64, st.tuples(st.integers(1, 9), st.just(2)), elements=st.floats(-1e3, 1e3)
)


@given(st.lists(VALUES, min_size=1, max_size=5))
def test_episodes_together_are_as_one(
    episodes: list[np.ndarray[tuple[int, int], np.dtype[np.float64]]],
) -> None:
    """Means and spreads of unequal episodes add up to those of all their rows."""
    found, whole = merged([of_rows(one) for one in episodes]), of_rows(np.concatenate(episodes))
    for name in ("min", "max", "mean", "std", "count"):
        assert found[name] == pytest.approx(whole[name], abs=1e-6), name


def test_pictures_are_counted_by_their_colours() -> None:
    """Two small pictures give what numpy says of their pixels, from 0 to 1."""
    pixels = np.random.default_rng(1).integers(0, 256, (2, 12, 16, 3), np.uint8)
    counted = PictureStatistics()
    for one in pixels:
        counted.add(av.VideoFrame.from_ndarray(one, format="rgb24"))
    found, levels = counted.result(), pixels.reshape(-1, 3) / 255
    assert found["count"] == [2]
    for name, wanted in {
        "min": levels.min(axis=0),
        "max": levels.max(axis=0),
        "mean": levels.mean(axis=0),
        "std": levels.std(axis=0),
        "q10": np.quantile(levels, 0.1, axis=0, method="inverted_cdf"),
        "q99": np.quantile(levels, 0.99, axis=0, method="inverted_cdf"),
    }.items():
        assert found[name].ravel() == pytest.approx(wanted), name
