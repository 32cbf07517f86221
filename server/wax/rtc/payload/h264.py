"""H.264 pictures as RTP payloads (RFC 6184, packetisation-mode 1). Pure."""

from __future__ import annotations

from typing import Final

from wax.encode.parameter_sets import units
from wax.rtc.payload.split import MIN_PACKET_BYTES, Payload, split_evenly

_FORBIDDEN: Final = 0x80
_IMPORTANCE: Final = 0x60
_TYPE: Final = 0x1F
_STAP_A: Final = 24
_FU_A: Final = 28
_FU_FIRST: Final = 0x80
_FU_LAST: Final = 0x40


def packets(data: bytes, *, max_bytes: int) -> list[Payload]:
    """Return one picture's payloads of at most `max_bytes` each; `data` is an Annex B stream.

    Consecutive small NAL units share a packet (STAP-A), large ones are split into equal parts
    (FU-A). Data before the first start code is dropped. Raises `ValueError` for `max_bytes` below
    32.
    """
    if max_bytes < MIN_PACKET_BYTES:
        raise ValueError(f"a payload needs room for {MIN_PACKET_BYTES} bytes")
    payloads: list[Payload] = []
    together: list[bytes] = []
    room = 0
    for unit in units(data):
        needs = 2 + len(unit)
        if needs > room:
            payloads += _joined(together)
            together, room = [], max_bytes - 1
        if len(unit) > max_bytes:
            payloads += _fragments(unit, max_bytes)
            room = 0
        else:
            together.append(unit)
            room -= needs
    return payloads + _joined(together)


def _joined(units: list[bytes]) -> list[Payload]:
    if len(units) < 2:
        return [(b"", unit) for unit in units]
    header = _STAP_A | max(unit[0] & _IMPORTANCE for unit in units)
    if any(unit[0] & _FORBIDDEN for unit in units):
        header |= _FORBIDDEN
    together = b"".join(len(unit).to_bytes(2, "big") + unit for unit in units)
    return [(bytes((header,)), together)]


def _fragments(unit: bytes, max_bytes: int) -> list[Payload]:
    indicator, kind = unit[0] & ~_TYPE | _FU_A, unit[0] & _TYPE
    parts = split_evenly(unit[1:], max_bytes - 2)
    heads = [kind | _FU_FIRST, *([kind] * (len(parts) - 2)), kind | _FU_LAST]
    return [(bytes((indicator, head)), part) for head, part in zip(heads, parts, strict=True)]
