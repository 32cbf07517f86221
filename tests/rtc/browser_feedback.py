"""Writes transport-wide feedback as a browser does, with chunks of any kind that fits."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from random import Random

REFERENCE_TICKS = 256


def feedback_packet(
    sequence_number: int, arrivals_ticks: Sequence[int | None], random: Random
) -> bytes:
    """Return the RTCP packet; arrivals in ticks of 250 µs, at most 2¹⁵ apart from each other."""
    first = next((ticks for ticks in arrivals_ticks if ticks is not None), 0)
    reference = first // REFERENCE_TICKS
    symbols: list[int] = []
    deltas = bytearray()
    before = reference * REFERENCE_TICKS
    for ticks in arrivals_ticks:
        if ticks is None:
            symbols.append(0)
            continue
        delta, before = ticks - before, ticks
        symbols.append(1 if 0 <= delta <= 255 else 2)
        deltas += delta.to_bytes(symbols[-1], "big", signed=symbols[-1] == 2)
    body = (
        (sequence_number & 0xFFFF).to_bytes(2, "big")
        + len(symbols).to_bytes(2, "big")
        + (reference & 0xFFFFFF).to_bytes(3, "big")
        + bytes((random.randrange(256),))
        + b"".join(chunk.to_bytes(2, "big") for chunk in _chunks(symbols, random))
        + deltas
    )
    padding = -len(body) % 4
    if padding:
        body += bytes((*([0] * (padding - 1)), padding))
    head = bytes((0x8F | (0x20 if padding else 0), 205))
    return head + (2 + len(body) // 4).to_bytes(2, "big") + random.randbytes(8) + body


def _chunks(symbols: Sequence[int], random: Random) -> Iterator[int]:
    at = 0
    while at < len(symbols):
        run = 1
        while at + run < len(symbols) and symbols[at + run] == symbols[at] and run < 0x1FFF:
            run += 1
        kind = random.choice(("run", "one", "two"))
        if kind == "one" and 2 not in symbols[at : at + 14]:
            yield 0x8000 | sum(s << 13 - i for i, s in enumerate(symbols[at : at + 14]))
            at += 14
        elif kind == "two":
            yield 0xC000 | sum(s << 12 - 2 * i for i, s in enumerate(symbols[at : at + 7]))
            at += 7
        else:
            yield symbols[at] << 13 | run
            at += run
