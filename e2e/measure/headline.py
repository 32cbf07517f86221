"""The few rows in the README, by which a newcomer judges WAX beside what else they could use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.published import Published
    from e2e.measure.row import Row

ROWS: Final = {
    "same-machine/1280x720/operator/picture_age_p50_ms/cells": "720p picture’s age, same host, p50",
    "same-machine/1280x720/operator/picture_age_p95_ms/cells": "… p95",
    "same-machine/1280x720/operator/sharpness_ssim/cells": "… likeness to the source (SSIM)",
    "internet-5m/1280x720/operator/picture_age_p95_ms/cells": "720p picture’s age, 5 Mbit/s, p95",
    "internet-5m/1280x720/operator/sharpness_ssim/cells": "… likeness to the source (SSIM)",
    "same-machine/operator/sound_age_p50_ms/cells": "sound’s age beside VGA, same host, p50",
    "internet-5m/audio-master/joined_skew_p95_ms/cells": "an observer’s skew at VGA, 5 Mbit/s, p95",
    "fan-out: slope": "server’s work for a further viewer at VGA",
    "network-vanishes": "the network vanishes → the robot is told to stop, max",
    "driver-killed": "the driver’s process is killed → the board stops, max",
    "stop-in-flood": "Stop beside a viewer’s flood → the robot is told to stop, p99",
    "reconnect-network: median": "another network → a new picture, p50",
}
"""What the README calls the rows, by their keys, whichever suite publishes them."""


def rows(published: Sequence[Published]) -> list[tuple[Published, Row]]:
    """Return the newest of each key, renamed; raises `MeasureError` if one is not published."""
    found = {
        row.key: (one, row)
        for one in sorted(published, key=lambda one: one.date)
        for row in one.rows
    }
    if lacking := [key for key in ROWS if key not in found]:
        raise MeasureError(f"nothing publishes {', '.join(lacking)}, which the README shows")
    named = [(found[key], what) for key, what in ROWS.items()]
    return [(one, row.model_copy(update={"what": what})) for (one, row), what in named]
