"""The time from a key press in the browser to the message that moves, on a driver's wire."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

from e2e.load.key_to_byte import GOAL_MS, changes, delays, strokes_at
from e2e.measure.row import summed

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.drivers.robots import Kind

_HOLD_S: Final = (0.08, 0.16)
_REST_S: Final = (0.1, 0.2)
"""As short as a tap, and yet at random phase against all that beats: there are many drivers."""


async def key_to_wire(kind: Kind, n: int) -> Row:
    """Press `n` times; the robot's clock is this machine's, as the browser's."""
    with TemporaryDirectory(prefix="wax-drivers-") as folder:
        robot = kind.robot(Path(folder))
        await robot.start()
        try:
            strokes, clock_error_ms = await strokes_at(
                robot.settings, n, robot.environment, hold_s=_HOLD_S, rest_s=_REST_S
            )
            robot.record.read()
        finally:
            await robot.stop()
    moves = changes(robot.record.frames)
    presses_ms, releases_ms = (delays(strokes, moves, down=down) for down in (True, False))
    return summed(
        "key",
        "key press → the message that moves",
        "ms",
        presses_ms,
        GOAL_MS,
        judged="p99",
        released=len(releases_ms),
        clock_error_ms=clock_error_ms,
    )
