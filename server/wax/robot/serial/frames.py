"""The dialect ``frames``, second edition, byte by byte (pure).

All numbers but the CRC are little-endian.

====== ====== ==============================================================================
offset size   what
====== ====== ==============================================================================
0      2      start: A5 5A
2      1      length N of the payload, 0 to 32
3      1      type, see below
4      2      sequence number, rises by one with each frame of this sender, wraps to 0
6      4      turn number; in frames of the robot the highest that it has seen
10     2      time-to-live in ms, 0 where the type has none
12     4      time on the robot's clock in ms, wraps to 0; in frames of the server its estimate
              from the robot's last report and the time since, 0 in hello
16     N      payload
16+N   2      CRC-16 of bytes 2 to 15+N, its high byte first: polynomial 1021, not reflected,
              no final xor; it starts with FFFF in hello, in all others with the session
====== ====== ==============================================================================

Started with FFFF this CRC is known as "CCITT-FALSE" and "IBM-3740"; 123456789 gives 29B1. With its
low byte first, it could miss a burst error of 16 bits at the end of a frame.

From the server:

- 00 hello, ``uint16 session``, 1 to 65534, drawn at random: this session is valid from now on, in
  both directions. Stop, forget turn and sequence, and report.
- 01 drive, ``int16 left, int16 right``: wheel speeds in mm/s, forward positive. They are valid for
  the time-to-live, at most 1000 ms, counted from arrival; after it the robot stops.
- 02 axis, ``uint8 number, int16 position``: move an axis to position / 10000 of its range,
  -10000 to 10000. Its number is its place in the configuration's ``axes``, from 0. Its
  time-to-live is how late it may be.
- 03 stop, no payload: stand still now, whatever the turn, the sequence and the time.
- 04 move, ``int16 linear, int16 lateral, int16 angular``: a motion in the plane, ahead and to the
  left in mm/s, turning left in mrad/s, valid as a drive is. The robot mixes its wheels itself, and
  slows them all by one factor where one would have to be too fast. Only for a robot with bit 2 of
  the flags; a server without it, and one whose robot does not move sideways, sends drive.

The robot refuses drive, move and axis

- of a lower turn than it has seen in this session;
- whose sequence number is not newer than that of the last accepted frame (a 16-bit difference of 1
  to 32767);
- whose time is older than their time-to-live, more than 50 ms ahead, or before the last hello, so
  that delayed or repeated frames move nothing, not even together with their hello;
- after a time-to-live ran out, until the next stop or hello: a robot that stopped itself does not
  start by itself;

and any move if it cannot move sideways.

Without a session, as after power-on, it accepts only hello.

From the robot, 20 times a second, and at once after a hello, when bit 0 of the flags changes and
when bit 1 is set:

- 81 report, ``uint16 battery_mv, uint8 bumpers, int32 left, int32 right, uint8 flags,
  uint16 sequence, uint16 damaged, uint16 refused``: battery voltage (0: not measured), pressed
  bumpers bit by bit, encoder ticks, flags (bit 0: a wheel turns; bit 1: stopped because a
  time-to-live ran out; bit 2: it obeys move), the sequence number of the last accepted frame, and
  how many since it started were damaged or refused (both wrap to 0). Without a session its CRC
  starts with FFFF.

A frame with an unknown type or length, or a wrong CRC, is ignored. Frames of another session always
fail the CRC, because the same bytes never give the same CRC from another start value. One to three
flipped bits, and any within 16 in a row, are always detected if the length is intact; of other
damage one in 65536 is not, and then still has to fit in turn, sequence and time.
"""

from __future__ import annotations

import binascii
import struct
from dataclasses import dataclass
from typing import Final

START: Final = b"\xa5\x5a"
MAX_PAYLOAD: Final = 32
POSITION_SCALE: Final = 10_000
NO_SESSION: Final = 0xFFFF
"""The CRC's start value without a session."""

_HEADER: Final = struct.Struct("<2sBBHIHI")
_CRC: Final = struct.Struct(">H")


@dataclass(frozen=True, slots=True)
class HelloBody:
    """A session begins, 1 to 65534."""

    session: int


@dataclass(frozen=True, slots=True)
class DriveBody:
    """Wheel speeds in mm/s, -32768 to 32767."""

    left_mmps: int
    right_mmps: int


@dataclass(frozen=True, slots=True)
class MoveBody:
    """A motion in the plane in mm/s and mrad/s, each -32768 to 32767."""

    linear_mmps: int
    lateral_mmps: int
    angular_mradps: int


@dataclass(frozen=True, slots=True)
class AxisBody:
    """Move axis `number` to `position` / 10000 of its range."""

    number: int
    position: int


@dataclass(frozen=True, slots=True)
class StopBody:
    """Stand still now."""


@dataclass(frozen=True, slots=True)
class ReportBody:
    """The robot's report of its state."""

    battery_mv: int
    bumpers: int
    left_ticks: int
    right_ticks: int
    flags: int
    sequence: int
    damaged: int = 0
    refused: int = 0

    @property
    def moving(self) -> bool:
        return bool(self.flags & 1)

    @property
    def timed_out(self) -> bool:
        return bool(self.flags & 2)

    @property
    def moves_sideways(self) -> bool:
        return bool(self.flags & 4)


Body = HelloBody | DriveBody | AxisBody | StopBody | MoveBody | ReportBody


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame; numbers too large for their field keep their lowest bits."""

    body: Body
    sequence: int = 0
    turn: int = 0
    ttl_ms: int = 0
    time_ms: int = 0


_TYPES: Final[dict[int, tuple[type[Body], struct.Struct]]] = {
    0x00: (HelloBody, struct.Struct("<H")),
    0x01: (DriveBody, struct.Struct("<hh")),
    0x02: (AxisBody, struct.Struct("<Bh")),
    0x03: (StopBody, struct.Struct("<")),
    0x04: (MoveBody, struct.Struct("<hhh")),
    0x81: (ReportBody, struct.Struct("<HBiiBHHH")),
}
_CODES: Final = {body: code for code, (body, _) in _TYPES.items()}


def encode(frame: Frame, session: int) -> bytes:
    """Return the bytes of a frame; raises `struct.error` if the body does not fit its fields."""
    code = _CODES[type(frame.body)]
    fields = [getattr(frame.body, name) for name in frame.body.__dataclass_fields__]
    payload = _TYPES[code][1].pack(*fields)
    header = _HEADER.pack(
        START,
        len(payload),
        code,
        frame.sequence & 0xFFFF,
        frame.turn & 0xFFFF_FFFF,
        frame.ttl_ms & 0xFFFF,
        frame.time_ms & 0xFFFF_FFFF,
    )
    return header + payload + _crc(header[len(START) :] + payload, code, session)


class Decoder:
    """Finds frames in a stream of bytes; never raises, keeps at most one unfinished frame.

    With a session it decodes hello and the frames of this session, as the server does. With None it
    decodes like the robot: the session of the last hello is valid, and none before it. After
    garbage it continues with the next valid start. `errors` counts bytes that began like a frame
    but were none, and frames of unknown types.
    """

    def __init__(self, session: int | None = None) -> None:
        self.session = NO_SESSION if session is None else session
        self.errors = 0
        self._follows_hello = session is None
        self._rest = b""

    def feed(self, data: bytes) -> list[Frame]:
        """Decode the next bytes; return the completed frames."""
        stream = self._rest + data
        frames: list[Frame] = []
        at = 0
        while True:
            at = _find_start(stream, at)
            if len(stream) - at < len(START) + 1:
                break
            length = stream[at + len(START)]
            if length > MAX_PAYLOAD:
                at = self._skip(at)
                continue
            end = at + _HEADER.size + length + _CRC.size
            if end > len(stream):
                break
            if not _holds(stream[at:end], self.session):
                at = self._skip(at)
                continue
            frame = _parse(stream[at:end])
            if frame is None:
                self.errors += 1
            else:
                frames.append(frame)
                if self._follows_hello and isinstance(frame.body, HelloBody):
                    self.session = frame.body.session
            at = end
        self._rest = stream[at:]
        return frames

    def _skip(self, at: int) -> int:
        self.errors += 1
        return at + 1


def _find_start(stream: bytes, at: int) -> int:
    """Return where the next start marker is or may begin, else the end."""
    start = stream.find(START, at)
    if start >= 0:
        return start
    return len(stream) - 1 if stream[at:].endswith(START[:1]) else len(stream)


def _holds(data: bytes, session: int) -> bool:
    covered = data[len(START) : -_CRC.size]
    return _crc(covered, data[len(START) + 1], session) == data[-_CRC.size :]


def _parse(data: bytes) -> Frame | None:
    _, _, code, sequence, turn, ttl_ms, time_ms = _HEADER.unpack_from(data)
    payload = data[_HEADER.size : -_CRC.size]
    body_type, layout = _TYPES.get(code, (None, None))
    if body_type is None or layout is None or layout.size != len(payload):
        return None
    body = body_type(*layout.unpack(payload))
    if isinstance(body, HelloBody) and not 0 < body.session < NO_SESSION:
        return None
    return Frame(body, sequence=sequence, turn=turn, ttl_ms=ttl_ms, time_ms=time_ms)


def _crc(data: bytes, code: int, session: int) -> bytes:
    return _CRC.pack(binascii.crc_hqx(data, NO_SESSION if code == _CODES[HelloBody] else session))
