"""The serial line of a hand control, byte by byte (pure).

The control sends a frame 50 times a second, and at once when a button changes; nothing is sent to
it. All frames have 9 bytes:

====== ====== ==============================================================================
offset size   what
====== ====== ==============================================================================
0      2      start: A5 5B
2      1      number, rises by one with each frame, wraps to 0
3      1      int8 stick, ahead is positive: -100 to 100
4      1      int8 stick, left is positive: -100 to 100
5      1      what is pressed now, bit by bit: 0 a hand is felt, 1 Stop, 2 "wait", 3 "go on",
              4 "left", 5 "right"
6      1      bits 0 to 5 of the byte before it, inverted, with bits 6 and 7 set
7      2      CRC-16 of bytes 2 to 6, its high byte first: polynomial 1021, not reflected, starts
              with FFFF, no final xor
====== ====== ==============================================================================

A control that can ask for sideways sends 7 bytes more, directly before each frame, also while that
stick is at rest. A server that does not know them skips them:

====== ====== ==============================================================================
0      2      start: A5 5C
2      1      number of the frame
3      1      int8 stick, sideways to the left is positive: -100 to 100
4      1      the byte before it, inverted
5      2      CRC-16 of bytes 2 to 4, as above
====== ====== ==============================================================================

A frame without them counts once a control has shown that it sends none, by two frames in a row. A
frame whose bytes are damaged is ignored, but for its Stop: at rest is what a control must have been
before it moves anything.

The control must read Stop from a contact that opens when pressed, so that a broken wire stops.
A frame with a wrong CRC or inverse is ignored, and so is one whose number is not newer (an 8-bit
difference of 1 to 127) than that of the frame before it, unless a second has passed without a
frame: a line that repeats old frames counts as silent. Of several requests in one frame, the first
in the order above counts.
"""

from __future__ import annotations

import binascii
import math
from typing import TYPE_CHECKING, Final

from wax.driver.hand import HandReading

if TYPE_CHECKING:
    from wax.driver.interface import Ask

START: Final = b"\xa5\x5b"
LENGTH: Final = 9
ASIDE: Final = b"\xa5\x5c"
ASIDE_LENGTH: Final = 7
STICK_SCALE: Final = 100

HELD, STOP = 1, 2
ASKS: Final[dict[Ask, int]] = {"wait": 4, "go_on": 8, "left": 16, "right": 32}
_BUTTONS: Final = 0b11_1111

RESTART_S: Final = 1.0
"""After this long without a frame the control may have restarted its numbers."""


def encode(reading: HandReading, number: int, *, has_aside: bool = False) -> bytes:
    """Return the frame of a reading, whose stick must be in range.

    `has_aside` says that the control can ask for sideways.
    """
    buttons = HELD * reading.is_held | STOP * reading.stop
    if reading.ask is not None:
        buttons |= ASKS[reading.ask]
    body = bytes(
        [
            number & 0xFF,
            round(reading.linear * STICK_SCALE) & 0xFF,
            round(reading.angular * STICK_SCALE) & 0xFF,
            buttons,
            ~buttons & 0xFF,
        ]
    )
    frame = START + body + _crc(body)
    if not has_aside:
        return frame
    lateral = round(reading.lateral * STICK_SCALE) & 0xFF
    aside = bytes([number & 0xFF, lateral, ~lateral & 0xFF])
    return ASIDE + aside + _crc(aside) + frame


class HandDecoder:
    """Finds frames in a stream of bytes; never raises, keeps at most one unfinished frame.

    It also keeps the few bytes before that, which may belong to it.
    `errors` counts bytes that began like a frame but were none, or lacked the bytes before it.
    """

    def __init__(self) -> None:
        self.errors = 0
        self._rest = b""
        self._searched = 0  # so many bytes of the rest
        self._ended = -1  # where in the rest the newest frame ended
        self._has_aside: bool | None = None
        self._number = 0
        self._at_s = -math.inf

    def feed(self, data: bytes, now_s: float) -> list[HandReading]:
        """Decode the next bytes; return the completed readings, timestamped `now_s`.

        A stick beyond its range is returned as it is, for the caller to judge.
        """
        stream = self._rest + data
        readings = []
        at = self._searched
        while (at := stream.find(START, at)) >= 0 and len(stream) - at >= LENGTH:
            frame = stream[at : at + LENGTH]
            if not _holds(frame):
                self.errors += 1
                at += 1
                continue
            if 0 < (frame[2] - self._number) & 0xFF < 128 or now_s - self._at_s >= RESTART_S:
                self._number, self._at_s = frame[2], now_s
                reading = self._read(frame, stream[max(0, at - ASIDE_LENGTH) : at], at, now_s)
                readings += [] if reading is None else [reading]
            at += LENGTH
            self._ended = at
        if at < 0:  # without a complete start marker, only its first byte can belong to a frame
            at = len(stream) - stream.endswith(START[:1])
        self._searched = min(at, ASIDE_LENGTH)
        self._rest = stream[at - self._searched :]
        self._ended -= at - self._searched
        return readings

    def _read(self, frame: bytes, before: bytes, at: int, now_s: float) -> HandReading | None:
        """Return the reading of a frame at this place; None if its stick sideways is unknown."""
        lateral = _aside(before, frame[2])
        if lateral is not None:
            self._has_aside = True
        elif self._has_aside is None and at == self._ended:
            self._has_aside = False
        if lateral is None and self._has_aside is not False:
            self.errors += self._has_aside is True
            lateral = math.nan
        reading = _parse(frame, lateral or 0.0, now_s)
        return reading if reading.stop or not math.isnan(reading.lateral) else None


def _holds(frame: bytes) -> bool:
    buttons, inverse = frame[5], frame[6]
    return _crc(frame[2:7]) == frame[7:] and buttons == ~inverse & 0xFF and buttons <= _BUTTONS


def _aside(before: bytes, number: int) -> float | None:
    """Return the stick sideways by the bytes before a frame, None if they are others."""
    body = before[2:5]
    if not before.startswith(ASIDE) or _crc(body) != before[5:] or body[0] != number:
        return None
    return _signed(body[1]) / STICK_SCALE if body[1] == ~body[2] & 0xFF else None


def _parse(frame: bytes, lateral: float, now_s: float) -> HandReading:
    buttons = frame[5]
    return HandReading(
        at_s=now_s,
        linear=_signed(frame[3]) / STICK_SCALE,
        angular=_signed(frame[4]) / STICK_SCALE,
        is_held=bool(buttons & HELD),
        stop=bool(buttons & STOP),
        ask=next((ask for ask, bit in ASKS.items() if buttons & bit), None),
        lateral=lateral,
    )


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def _crc(body: bytes) -> bytes:
    return binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "big")
