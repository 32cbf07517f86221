"""The few rows in the README, by which a newcomer judges WAX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.published import Published
    from e2e.measure.row import Row

ROWS: Final = (
    "same-machine/operator/picture_age_p95_ms/cells",
    "internet-5m/operator/picture_age_p95_ms/cells",
    "wireless-1m/operator/pictures_640_per_s/cells",
    "same-machine/operator/sound_age_p50_ms/cells",
    "internet-5m/audio-master/joined_skew_p95_ms/cells",
    "modem-56k/operator/concealed_percent/cells",
    "fan-out: slope",
    "same-machine/operator/picture_age_p95_ms/crowd",
    "network-vanishes",
    "driver-killed",
    "stop-in-flood",
    "reconnect-network: median",
)
"""The rows by their keys, whichever suite publishes them."""


def rows(published: Sequence[Published]) -> list[tuple[Published, Row]]:
    """Return the newest of each key; raises `MeasureError` if one is not published."""
    found = {
        row.key: (one, row)
        for one in sorted(published, key=lambda one: one.date)
        for row in one.rows
    }
    if lacking := [key for key in ROWS if key not in found]:
        raise MeasureError(f"nothing publishes {', '.join(lacking)}, which the README shows")
    return [found[key] for key in ROWS]
