"""The statistics by which trainers normalise a dataset, as LeRobot stores them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from av.video.frame import VideoFrame
    from numpy.typing import NDArray

    Stats = dict[str, NDArray[np.float64]]

_QUANTILES: Final = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_WIDTH: Final = 160
"""Pictures are reduced to about this width before they are counted."""


def of_rows(rows: NDArray[Any]) -> Stats:
    """Return the statistics of each column of an episode's rows."""
    values = rows.astype(np.float64).reshape(len(rows), -1)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([float(len(values))]),
        **{name: np.quantile(values, share, axis=0) for name, share in _QUANTILES.items()},
    }


class PictureStatistics:
    """Counts how bright the pictures of an episode are, for each of red, green and blue."""

    def __init__(self) -> None:
        self._counts = np.zeros((3, 256), np.int64)
        self._pictures = 0

    def add(self, frame: VideoFrame) -> None:
        """Count a picture."""
        step = max(1, frame.width // _WIDTH)
        width, height = frame.width // step, max(1, frame.height // step)
        pixels = frame.to_ndarray(format="rgb24", width=width, height=height)
        for channel in range(3):
            self._counts[channel] += np.bincount(pixels[..., channel].ravel(), minlength=256)
        self._pictures += 1

    def result(self) -> Stats:
        """Return the statistics, from 0 (dark) to 1, in LeRobot's shape of three channels."""
        levels = np.arange(256) / 255
        total = self._counts.sum(axis=1)
        shares = self._counts.cumsum(axis=1) / total[:, None]
        mean = (self._counts * levels).sum(axis=1) / total
        square = (self._counts * levels**2).sum(axis=1) / total
        found = {
            "min": levels[(self._counts > 0).argmax(axis=1)],
            "max": levels[255 - (self._counts[:, ::-1] > 0).argmax(axis=1)],
            "mean": mean,
            "std": np.sqrt(np.maximum(0.0, square - mean**2)),
            **{name: levels[(shares >= at).argmax(axis=1)] for name, at in _QUANTILES.items()},
        }
        shaped = {name: values.reshape(3, 1, 1) for name, values in found.items()}
        return shaped | {"count": np.array([float(self._pictures)])}


def merged(episodes: Sequence[Stats]) -> Stats:
    """Return the statistics of all episodes; quantiles are means of theirs, as LeRobot has it."""
    counts = np.array([one["count"][0] for one in episodes])
    weights = counts / counts.sum()

    def mean_of(values: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        mean: NDArray[np.float64] = np.tensordot(weights, np.stack(values), axes=1)
        return mean

    mean = mean_of([one["mean"] for one in episodes])
    spread = mean_of([one["std"] ** 2 + (one["mean"] - mean) ** 2 for one in episodes])
    return {
        "min": np.min([one["min"] for one in episodes], axis=0),
        "max": np.max([one["max"] for one in episodes], axis=0),
        "mean": mean,
        "std": np.sqrt(spread),
        "count": np.array([counts.sum()]),
        **{name: mean_of([one[name] for one in episodes]) for name in _QUANTILES},
    }


def as_json(stats: Mapping[str, Stats]) -> dict[str, dict[str, list[Any]]]:
    """Return statistics as lists, with whole counts."""
    return {
        feature: {
            name: [int(values[0])] if name == "count" else values.tolist()
            for name, values in of.items()
        }
        for feature, of in stats.items()
    }
