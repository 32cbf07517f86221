"""Splits a byte stream into lines, and parses a robot's reports in them (pure)."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from wax.config.bases import WHEELS, WHEELS_OF
from wax.config.line_template import LineTemplate
from wax.config.text_dialect import REPORTED
from wax.robot.serial.odometry import Odometry

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Pose

MAX_LINE: Final = 128
STALE_S: Final = 1.0
"""A report older than this is expired; one that is polled less often, after 2.5 polls."""

_ENDS: Final = re.compile(rb"[\r\n]+")
_MAX_BUMPERS: Final = 0xFF


class Lines:
    """Splits bytes into lines, ignoring empty and overlong ones. Keeps at most one line."""

    def __init__(self) -> None:
        self._rest = b""
        self._is_lost = False

    def feed(self, data: bytes) -> list[str]:
        *whole, rest = _ENDS.split(self._rest + data)
        if self._is_lost and whole:
            whole[0] = b""
        self._is_lost = (self._is_lost and not whole) or len(rest) > MAX_LINE
        self._rest = b"" if self._is_lost else rest
        texts = [line.decode("ascii", "replace").strip() for line in whole if len(line) <= MAX_LINE]
        return [text for text in texts if text]


class Reports:
    """The values in the robot's lines that match a pattern of `[robot.serial.text] reports`."""

    def __init__(self, settings: RobotSettings) -> None:
        self._templates = [LineTemplate(one, REPORTED) for one in settings.serial.text.reports]
        self._odometry = Odometry(settings)
        self._tick_names = tuple(f"{wheel}_ticks" for wheel in WHEELS_OF[settings.base])
        own = settings.serial.text
        self._stale_s = max(STALE_S, 2.5 * len(own.ask) * own.ask_ms / 1000.0)
        self.forget()

    def forget(self) -> None:
        """Begin a connection."""
        self._told: dict[str, tuple[float, float]] = {}
        self._ticks: tuple[int, ...] | None = None
        self._turned: tuple[bool, float] | None = None
        self._odometry.forget()

    def parse_line(self, line: str, now_s: float) -> bool:
        """Parse a line; return whether it matches a pattern."""
        read = [template.found(line) for template in self._templates]
        # A line may match several patterns, one of which has fewer numbers.
        found = max((one for one in read if one is not None), key=len, default=None)
        if found is None:
            return False
        self._told |= {name: (value, now_s) for name, value in found.items()}
        self._turn(found, now_s)
        return True

    def moving(self, now_s: float) -> bool | None:
        """Whether a wheel turns, by the reports that show it; None if unknown."""
        said = [self._newest(name, now_s) for name in ("moving", *WHEELS)]
        known = [value != 0.0 for value in said if value is not None]
        if self._turned is not None and now_s - self._turned[1] < self._stale_s:
            known.append(self._turned[0])
        return any(known) if known else None

    def battery_v(self, now_s: float) -> float | None:
        for name, parts in (("battery_v", 1.0), ("battery_dv", 10.0), ("battery_mv", 1000.0)):
            value = self._newest(name, now_s)
            if value:  # 0: not measured
                return value / parts
        return None

    def bumpers(self, now_s: float) -> int:
        return int(self._newest("bumpers", now_s) or 0.0) & _MAX_BUMPERS

    @property
    def pose(self) -> Pose | None:
        return self._odometry.pose

    def known(self) -> dict[str, float]:
        ticks = () if self._ticks is None else zip(self._tick_names, self._ticks, strict=True)
        known = {name: float(count) for name, count in ticks}
        return known | {f"{wheel}_mps": mps for wheel, mps in self._odometry.speeds.items()}

    def _newest(self, name: str, now_s: float) -> float | None:
        value, at_s = self._told.get(name, (0.0, -self._stale_s))
        return value if name in self._told and now_s - at_s < self._stale_s else None

    def _turn(self, found: dict[str, float], now_s: float) -> None:
        """Compare the ticks of all wheels, taken as simultaneous, with the last ones."""
        if not found.keys() >= set(self._tick_names):
            return
        ticks = tuple(int(found[name]) for name in self._tick_names)
        if self._ticks is not None:
            self._turned = (ticks != self._ticks, now_s)
        self._ticks = ticks
        self._odometry.take(ticks, now_s)
