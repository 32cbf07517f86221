"""IPv4 packets of UDP and TCP: their two ends, read and rewritten (RFC 791, 768, 9293). Pure."""

from __future__ import annotations

import struct
from ipaddress import IPv4Address
from typing import Final, NamedTuple

UDP: Final = 17
TCP: Final = 6
_CHECKSUM_AT: Final = {UDP: 6, TCP: 16}
"""In the header of each."""
_SOURCE, _TARGET = 12, 16
"""Of the addresses in the IPv4 header; the ports have the same order in theirs."""


class Port(NamedTuple):
    """An address and a port of it."""

    host: str
    port: int


class Flow(NamedTuple):
    """Where a packet comes from and goes to."""

    protocol: int
    source: Port
    target: Port


def read(packet: bytes) -> Flow | None:
    """Return the two ends; None for what is neither UDP nor TCP, or a fragment."""
    if len(packet) < 20 or packet[0] >> 4 != 4 or packet[9] not in _CHECKSUM_AT:
        return None
    header = (packet[0] & 15) * 4
    if len(packet) < header + 8 or int.from_bytes(packet[6:8], "big") & 0x3FFF:
        return None
    source, target = struct.unpack_from("!HH", packet, header)
    return Flow(
        packet[9], Port(_host(packet, _SOURCE), source), Port(_host(packet, _TARGET), target)
    )


def with_source(packet: bytes, source: Port) -> bytes:
    """Return a packet, which `read` has understood, as if it came from elsewhere."""
    return _with(packet, _SOURCE, 0, source)


def with_target(packet: bytes, target: Port) -> bytes:
    """Return a packet, which `read` has understood, as if it went elsewhere."""
    return _with(packet, _TARGET, 2, target)


def _host(packet: bytes, at: int) -> str:
    return str(IPv4Address(packet[at : at + 4]))


def _with(packet: bytes, address_at: int, port_at: int, new: Port) -> bytes:
    out = bytearray(packet)
    header = (packet[0] & 15) * 4
    sum_at = header + _CHECKSUM_AT[packet[9]]
    old_address, old_port = packet[address_at : address_at + 4], packet[header + port_at :][:2]
    address, port = IPv4Address(new.host).packed, new.port.to_bytes(2, "big")
    out[address_at : address_at + 4] = address
    out[header + port_at : header + port_at + 2] = port
    _mend(out, 10, old_address, address)
    if any(out[sum_at : sum_at + 2]) or packet[9] == TCP:  # UDP may have none
        _mend(out, sum_at, old_address + old_port, address + port)
    return bytes(out)


def _mend(out: bytearray, at: int, old: bytes, new: bytes) -> None:
    """Correct the checksum at `at` for words that have changed (RFC 1624)."""
    total = 0xFFFF ^ int.from_bytes(out[at : at + 2], "big")
    for word in range(0, len(old), 2):
        total += 0xFFFF ^ int.from_bytes(old[word : word + 2], "big")
        total += int.from_bytes(new[word : word + 2], "big")
    while total > 0xFFFF:
        total = (total & 0xFFFF) + (total >> 16)
    out[at : at + 2] = (0xFFFF ^ total).to_bytes(2, "big")
