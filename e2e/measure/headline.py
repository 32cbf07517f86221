"""The few rows by which somebody who has never heard of WAX judges it, in the README."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError
from e2e.measure.published import load
from e2e.measure.table import to_headline

if TYPE_CHECKING:
    from e2e.measure.published import Published
    from e2e.measure.row import Row

HEADLINE: Final = "headline"
ROWS: Final = (
    ("goals", "same-machine/operator/picture_age_p95_ms/cells"),
    ("goals", "internet-5m/operator/picture_age_p95_ms/cells"),
    ("goals", "wireless-1m/operator/pictures_640_per_s/cells"),
    ("sound", "same-machine/operator/sound_age_p50_ms/cells"),
    ("sound", "internet-5m/audio-master/joined_skew_p95_ms/cells"),
    ("sound", "modem-56k/operator/concealed_percent/cells"),
    ("bench", "fan-out: slope"),
    ("goals", "same-machine/operator/picture_age_p95_ms/crowd"),
    ("faults", "network-vanishes"),
    ("faults", "driver-killed"),
    ("faults", "stop-in-flood"),
    ("public", "reconnect-network: median"),
)
"""Each by its suite and key."""


def headline(*, is_stale: bool | None = None) -> str:
    """Render them; raises `MeasureError` where one is not published."""
    found = [_row(suite, key) for suite, key in ROWS]
    stale = any(published.is_stale for published, _ in found) if is_stale is None else is_stale
    return to_headline(found, is_stale=stale)


def _row(suite: str, key: str) -> tuple[Published, Row]:
    published = _loaded(suite)
    for row in published.rows:
        if row.key == key:
            return published, row
    raise MeasureError(f"{suite} publishes no {key!r}")


@cache
def _loaded(suite: str) -> Published:
    return load(suite)
