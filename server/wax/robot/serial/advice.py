"""Warnings about settings that `[robot.serial]` allows (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from wax.config.serial import SerialSettings


class Advice(NamedTuple):
    """What is wrong and what to do, as two sentences without full stops."""

    problem: str
    remedy: str


NO_TTL: Final = Advice(
    "As far as WAX knows the board follows its last line for ever, so a pulled cable leaves the"
    " robot moving (robot.serial.text.ttl_ms is 0)",
    "Give the board's program a timeout, and write it there",
)
NO_END: Final = Advice(
    "robot.serial.text.drive does not end with \\r or \\n",
    "Check what its program waits for: most do what a line says only after one of them",
)


def advised(serial: SerialSettings) -> list[Advice]:
    """Return the warnings, the worst first."""
    if serial.dialect != "text":
        return []
    ends = serial.text.drive.endswith(("\r", "\n"))
    return [*([] if serial.text.ttl_ms else [NO_TTL]), *([] if ends else [NO_END])]
