"""The figures of a cell: their names and their labels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.delay.changes import FRESH_MS, after_changes
from e2e.delay.names import changes_s
from e2e.instrument.sums import BRIDGED_MS, figures, window
from e2e.peers.sizes import VGA

if TYPE_CHECKING:
    from e2e.delay.cell import Cell
    from e2e.delay.readings import Readings

MEASURES: Final[dict[str, tuple[str, str]]] = {
    "picture_age_p50_ms": ("picture, p50", "ms"),
    "picture_age_p95_ms": ("picture, p95", "ms"),
    "arrival_age_p50_ms": ("picture’s arrival, p50", "ms"),
    "arrival_age_p95_ms": ("picture’s arrival, p95", "ms"),
    "sharpness_ssim": ("sharpness, SSIM", ""),
    "sharpness_psnr_db": ("sharpness, PSNR", "dB"),
    "sound_age_p50_ms": ("sound, p50", "ms"),
    "sound_age_p95_ms": ("sound, p95", "ms"),
    "skew_p50_ms": ("skew, p50", "ms"),
    "joined_skew_p95_ms": ("|skew|, p95, from 3 s after joining", "ms"),
    "pictures_per_s": ("pictures", "/s"),
    "pictures_1280_per_s": ("pictures at 1280×720", "/s"),
    "pictures_640_per_s": ("pictures at 640×480", "/s"),
    "pictures_160_per_s": ("pictures at 160×120 or more", "/s"),
    "longest_freeze_ms": ("longest freeze", "ms"),
    "first_picture_ms": ("first picture", "ms"),
    "picture_drift_ms_per_min": ("picture drift", "ms/min"),
    "sound_drift_ms_per_min": ("sound drift", "ms/min"),
    "command_round_trip_p50_ms": ("command, p50", "ms"),
    "command_round_trip_p95_ms": ("command, p95", "ms"),
    "set_points_per_s": ("set-points sent", "/s"),
    "concealed_percent": ("concealed sound", "%"),
    "stretched_percent": ("stretched sound", "%"),
    "pauses": ("audible pauses", ""),
    "pauses_per_min": (f"pauses above {BRIDGED_MS:.0f} ms", "/min"),
    "longest_pause_ms": ("longest pause", "ms"),
    "breaks": ("breaks of the connection", ""),
    "fresh_after_ms": (f"picture under {FRESH_MS:.0f} ms again", "ms"),
    "step_pause_ms": ("longest pause after the step", "ms"),
    "full_after_ms": ("full quality after recovery", "ms"),
    "picture_recovered_ms": ("picture after the last change", "ms"),
    "received_kb_per_s": ("received", "kB/s"),
    "sent_kb_per_s": ("sent", "kB/s"),
    "server_cpu": ("server CPU", "%"),
    "server_memory_mib": ("server memory", "MiB"),
    "browser_cpu": ("browser CPU", "%"),
    "machine_busy": ("the whole machine", "%"),
    "crowd_least_per_s": ("crowd, least pictures", "/s"),
    "fail_safe_s": ("fail-safe mode", "s"),
    "link_late_percent": ("late in the emulator", "%"),
}
"""Label and unit."""


def measured(
    cell: Cell, readings: Readings, settle_s: float, changes_began_ms: float | None = None
) -> dict[str, float | None]:
    """Return every figure that the readings have; None means measured but never reached."""
    within = window(readings, settle_s=settle_s)
    found: dict[str, float | None] = {**figures(readings, within)}
    if cell.given is VGA:  # whose pictures are never that large
        found.pop("pictures_1280_per_s", None)
    steps_s = changes_s(cell.profile)
    if changes_began_ms is not None and len(steps_s) > 1:
        worse_ms, whole_ms = (changes_began_ms + 1000 * steps_s[place] for place in (0, -1))
        found |= after_changes(readings, worse_ms, whole_ms, within.to_ms)
    return found
