"""Redundant audio: packets that repeat earlier sound (RFC 2198). Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

HEADER_BYTES: Final = 4
"""The header of each earlier unit; that of the newest is a single byte."""

_MAX_TICKS: Final = (1 << 14) - 1
_MAX_BLOCK_BYTES: Final = (1 << 10) - 1
_MORE: Final = 0x80


def red_payload(
    primary: bytes, earlier: Sequence[tuple[int, bytes]], payload_type: int, max_bytes: int
) -> bytes:
    """Return the newest unit of sound with as many `earlier` ones as fit into `max_bytes`.

    Each earlier one is its age in ticks of the RTP clock before the newest, and the unit, in any
    order. Units that are empty, above 1023 bytes or not within 1 to 16383 ticks (341 ms at 48 kHz)
    are dropped, then the oldest if space is short. The newest is always included, even if it alone
    is too long. `payload_type` is that of the sound itself, Opus in Chromium's ``111/111``.
    """
    room = max_bytes - 1 - len(primary)
    heads, blocks = bytes((payload_type & 0x7F,)), primary
    for ticks, unit in sorted(earlier, key=_ticks):
        if not (0 < ticks <= _MAX_TICKS and 0 < len(unit) <= _MAX_BLOCK_BYTES):
            continue
        room -= HEADER_BYTES + len(unit)
        if room < 0:
            break
        head = (_MORE | payload_type & 0x7F) << 24 | ticks << 10 | len(unit)
        heads, blocks = head.to_bytes(HEADER_BYTES, "big") + heads, unit + blocks
    return heads + blocks


def _ticks(block: tuple[int, bytes]) -> int:
    return block[0]
