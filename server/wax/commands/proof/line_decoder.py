"""Decode the traffic on the serial line in either dialect (pure)."""

from __future__ import annotations

import math
import secrets
from typing import TYPE_CHECKING, Protocol

from wax.commands.proof.measure import Event
from wax.robot.serial.frames import (
    NO_SESSION,
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    ReportBody,
    StopBody,
    encode,
)

if TYPE_CHECKING:
    from wax.config.serial import BytesDialectSettings, SerialSettings


class LineDecoder(Protocol):
    """Turns passing bytes into events; it needs all of them, in order."""

    @property
    def reports(self) -> bool:
        """Whether the robot reports if it moves."""
        ...

    def said(self, data: bytes, at_s: float) -> list[Event]:
        """Decode bytes written to the robot."""
        ...

    def told(self, data: bytes, at_s: float) -> list[Event]:
        """Decode bytes from the robot."""
        ...

    def last_words(self) -> bytes:
        """Return the bytes that stop the robot, whatever was sent before."""
        ...


def language_of(settings: SerialSettings) -> LineDecoder:
    """Return the decoder for the configured dialect."""
    return Frames() if settings.dialect == "frames" else Bytes(settings.bytes)


class Frames:
    """The dialect ``frames``: the session of the last hello is valid, both ways."""

    def __init__(self) -> None:
        self._server = Decoder()
        self._robot = Decoder(NO_SESSION)

    @property
    def reports(self) -> bool:
        return True

    def said(self, data: bytes, at_s: float) -> list[Event]:
        events = []
        for frame in self._server.feed(data):
            match frame.body:
                case DriveBody(left, right):
                    speed_mps = max(abs(left), abs(right)) / 1000.0
                    events.append(Event(at_s, "said", speed_mps > 0, speed_mps))
                case MoveBody(linear, lateral, angular):
                    moves = (linear, lateral, angular) != (0, 0, 0)
                    speed_mps = math.hypot(linear, lateral) / 1000.0
                    events.append(Event(at_s, "said", moves, speed_mps))
                case StopBody() | HelloBody():
                    events.append(Event(at_s, "said", moves=False, speed_mps=0.0))
        if self._robot.session != self._server.session:
            self._robot = Decoder(self._server.session)
        return events

    def told(self, data: bytes, at_s: float) -> list[Event]:
        return [
            Event(at_s, "told", frame.body.moving)
            for frame in self._robot.feed(data)
            if isinstance(frame.body, ReportBody)
        ]

    def last_words(self) -> bytes:
        session = 1 + secrets.randbelow(NO_SESSION - 1)
        return encode(Frame(HelloBody(session)), session) + encode(
            Frame(StopBody(), sequence=1), session
        )


class Bytes:
    """The dialect ``bytes``: a direction holds until the next one, and there are no reports."""

    def __init__(self, table: BytesDialectSettings) -> None:
        self._stop = table.stop
        self._speeds = (table.fine, table.gross)

    @property
    def reports(self) -> bool:
        return False

    def said(self, data: bytes, at_s: float) -> list[Event]:
        commands = (octet for octet in data if octet not in self._speeds)
        return [Event(at_s, "said", octet != self._stop) for octet in commands]

    def told(self, data: bytes, at_s: float) -> list[Event]:  # noqa: ARG002  # the protocol's form
        return []

    def last_words(self) -> bytes:
        return bytes([self._stop])
