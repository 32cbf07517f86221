"""The board's frames and motion, from its own log; pure except for reading the file.

Times are CLOCK_MONOTONIC, which all processes of this machine share as `time.monotonic`.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from wax.config.robot import RobotSettings
from wax.robot.wheels import WheelGeometry

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from wax.config.bases import Base


_PLANE: Final = ("linear", "lateral", "angular")
_BACK: Final = ("back", "back_left", "back_right")
_BASES: Final[dict[int, Base]] = {1: "omni", 2: "mecanum"}
"""By the number of their back wheels."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One frame that arrived undamaged and belongs to this session; not every one is `taken`."""

    at_s: float
    kind: str
    taken: bool
    turn: int
    left_mmps: int
    right_mmps: int
    plane: tuple[int, ...] = ()
    """Ahead and to the left in mm/s, and turning in mrad/s, of a move."""

    @property
    def speeds(self) -> tuple[int, ...]:
        """All that it asks for; equal ones are the same motion."""
        return (self.left_mmps, self.right_mmps, *self.plane)

    @property
    def moves(self) -> bool:
        """Return whether the board turns its wheels for it."""
        return self.is_motion and self.taken

    @property
    def is_motion(self) -> bool:
        return self.kind in ("drive", "move") and any(self.speeds)


@dataclass(frozen=True, slots=True)
class Wheels:
    """The wheels' actual speed from now on."""

    at_s: float
    left_mmps: int
    right_mmps: int
    back_mmps: tuple[int, ...] = ()
    """One of three wheels, two of four, none of two."""

    @property
    def _all_mmps(self) -> tuple[int, ...]:
        return (self.left_mmps, self.right_mmps, *self.back_mmps)

    @property
    def stand(self) -> bool:
        return not any(self._all_mmps)

    @property
    def faster_mmps(self) -> float:
        """The speed of the faster wheel, in either direction; with a back wheel, of the middle."""
        if not self.back_mmps:
            return max(abs(self.left_mmps), abs(self.right_mmps))
        geometry = WheelGeometry(RobotSettings(), _BASES[len(self.back_mmps)])
        return geometry.motion(self._all_mmps).speed_mps


@dataclass(frozen=True, slots=True)
class Stopping:
    """The effects of a fault, in ms after it; None for an effect that never came.

    `told_ms` ends with the first stopping frame, `by_itself_ms` with the board's own watchdog;
    `travelled_mm` is the distance until both wheels stand. `moved_again_ms` are the frames that
    would have moved the robot after the first of the two, until the end of the look.
    """

    told_ms: float | None
    by_itself_ms: float | None
    travelled_mm: float | None
    moved_again_ms: list[float]

    @property
    def ends_ms(self) -> float | None:
        """The end of the motion, whatever ended it."""
        ends = [end for end in (self.told_ms, self.by_itself_ms) if end is not None]
        return min(ends, default=None)


class Record:
    """All that a board has logged so far; `read` adds new lines."""

    lasts_s = 0.06
    """For how long a frame moves the robot."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._offset = 0
        self._half = b""
        self.frames: list[Seen] = []
        self.wheels: list[Wheels] = []
        self.expiries_s: list[float] = []

    def read(self) -> None:
        self.take(json.loads(line) for line in self.lines())

    def lines(self) -> list[bytes]:
        """Return the whole lines that are new."""
        with self._path.open("rb") as log:
            log.seek(self._offset)
            data = log.read()
        self._offset += len(data)
        *lines, self._half = (self._half + data).split(b"\n")
        return [line for line in lines if line]

    def take(self, events: Iterable[dict[str, Any]]) -> None:
        """Add events in the order in which they happened."""
        for event in events:
            at_s = float(event["t_s"])
            match event["event"]:
                case "frame":
                    self.frames.append(
                        Seen(
                            at_s,
                            event["type"],
                            event["verdict"] == "taken",
                            int(event["turn"]),
                            int(event["left"]),
                            int(event["right"]),
                            tuple(int(event[part]) for part in _PLANE if part in event),
                        )
                    )
                case "wheels":
                    back = tuple(int(event[wheel]) for wheel in _BACK if wheel in event)
                    self.wheels.append(Wheels(at_s, int(event["left"]), int(event["right"]), back))
                case "ttl":
                    self.expiries_s.append(at_s)

    def moved_at(self, at_s: float) -> bool:
        index = bisect_right(self.frames, at_s, key=lambda frame: frame.at_s) - 1
        if index < 0 or not self.frames[index].moves:
            return False
        turning = bisect_right(self.wheels, at_s, key=lambda wheels: wheels.at_s) - 1
        fresh = at_s - self.frames[index].at_s < self.lasts_s
        return fresh and turning >= 0 and not self.wheels[turning].stand

    def between(self, since_s: float, until_s: float) -> list[Seen]:
        """Return the frames that came after `since_s`, up to `until_s`."""
        begin = bisect_right(self.frames, since_s, key=lambda frame: frame.at_s)
        end = bisect_right(self.frames, until_s, key=lambda frame: frame.at_s)
        return self.frames[begin:end]

    def stopping(self, since_s: float, until_s: float) -> Stopping:
        """Return how the motion at `since_s` ended, up to `until_s`."""
        frames = self.between(since_s, until_s)
        told_s = next((frame.at_s for frame in frames if not frame.is_motion), None)
        expiry_s = next((at_s for at_s in self.expiries_s if since_s < at_s <= until_s), None)
        ended_s = min((at for at in (told_s, expiry_s) if at is not None), default=until_s)

        def since_ms(at_s: float | None) -> float | None:
            return None if at_s is None else (at_s - since_s) * 1000

        return Stopping(
            told_ms=since_ms(told_s),
            by_itself_ms=since_ms(expiry_s),
            travelled_mm=self._travelled_mm(since_s, until_s),
            moved_again_ms=[
                (frame.at_s - since_s) * 1000
                for frame in frames
                if frame.moves and frame.at_s > ended_s
            ],
        )

    def _travelled_mm(self, since_s: float, until_s: float) -> float | None:
        """Return the distance of the faster wheel until both stand; None if they do not.

        The board logs when its wheels begin to change their speed and when they have done so.
        Between two lines the higher speed counts, so that the distance is never too short.
        """
        next_one = bisect_right(self.wheels, since_s, key=lambda wheels: wheels.at_s)
        before = self.wheels[next_one - 1] if next_one else Wheels(since_s, 0, 0)
        way_mm, from_s = 0.0, since_s
        for one in self.wheels[next_one:]:
            if one.at_s > until_s:
                break
            way_mm += max(before.faster_mmps, one.faster_mmps) * (one.at_s - from_s)
            if one.stand:
                return way_mm
            before, from_s = one, one.at_s
        return None
