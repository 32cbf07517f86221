"""The core on a bench: greeted, with a clock and a server that speaks to it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.firmware.core import Core, Settings, Verdict

from wax.robot.serial.frames import (
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    ReportBody,
    encode,
)

if TYPE_CHECKING:
    from wax.robot.serial.frames import Body

VECTORS: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "robot" / "vectors" / "frames.json").read_text(encoding="utf-8")
)
SESSION: int = VECTORS["session"]
WRAP = 2**32
AHEAD = DriveBody(600, 600)


class Bench:
    """A core that was greeted, the server's numbers, and a clock."""

    def __init__(self, start_ms: int = 0, **settings: Any) -> None:
        self.now_ms = start_ms
        self.core = Core(Settings(**settings), start_ms)
        self.sequence = 0
        self.session = SESSION
        self.say(HelloBody(SESSION))

    def say(self, body: Body, **fields: int) -> Verdict | None:
        """Say it as the server does but for the fields given; None if it is no frame of ours."""
        self.sequence = fields.pop("sequence", self.sequence + 1)
        session = fields.pop("session", self.session)
        whole = {"turn": 1, "ttl_ms": 200, "time_ms": self.now_ms} | fields
        frame = Frame(body, sequence=self.sequence, **whole)
        found = self.core.hear(encode(frame, session), self.now_ms)
        return found[0][1] if found else None

    def wait(self, pause_ms: int, **inputs: Any) -> None:
        """Let time pass, a millisecond at a time."""
        for _ in range(pause_ms):
            self.now_ms += 1
            self.core.tick(self.now_ms, **inputs)

    def report(self) -> Frame | None:
        found = Decoder(self.session).feed(self.core.report(self.now_ms))
        return found[0] if found else None

    def told(self) -> ReportBody:
        """Give the next report, which comes within 50 ms."""
        for _ in range(51):
            frame = self.report()
            if frame is not None:
                assert isinstance(frame.body, ReportBody)
                return frame.body
            self.wait(1)
        raise AssertionError("no report")

    @property
    def stands(self) -> bool:
        return not any(self.core.wheels_mmps)
