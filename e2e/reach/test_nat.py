"""The router of the tests: it lets through what a household's does, and nothing else."""

from __future__ import annotations

import struct
from ipaddress import IPv4Address

import pytest
from hypothesis import given
from hypothesis import strategies as st

from e2e.reach.nat import Nat
from e2e.reach.packet import TCP, UDP, Port, read, with_source, with_target

HOST = Port("192.168.7.2", 5000)
ROBOT = Port("203.0.113.1", 8081)
STRANGER = Port("198.51.100.9", 8081)
PUBLIC = "203.0.113.2"
PORTS = st.builds(Port, st.ip_addresses(v=4).map(str), st.integers(0, 65535))


def _sum(data: bytes) -> int:
    """Add the words as a receiver does; 0xFFFF if the checksum among them is right."""
    total: int = sum(struct.unpack(f"!{(len(data) + 1) // 2}H", data + b"\0" * (len(data) % 2)))
    while total > 0xFFFF:
        total = (total & 0xFFFF) + (total >> 16)
    return total


def packet(protocol: int, source: Port, target: Port, payload: bytes = b"data") -> bytes:
    addresses = IPv4Address(source.host).packed + IPv4Address(target.host).packed
    size = len(payload) + (8 if protocol == UDP else 20)
    ports = struct.pack("!HH", source.port, target.port)
    pseudo = addresses + struct.pack("!BBH", 0, protocol, size)
    if protocol == UDP:
        head, tail = ports + struct.pack("!H", size), b""
    else:
        head, tail = ports + struct.pack("!IIBBH", 1, 2, 0x50, 0x10, 1000), bytes(2)
    check = 0xFFFF ^ _sum(pseudo + head + bytes(2) + tail + payload)
    segment = head + (check or 0xFFFF).to_bytes(2, "big") + tail + payload
    ip = struct.pack("!BBHHHBB", 0x45, 0, 20 + size, 7, 0, 64, protocol)
    ip_check = 0xFFFF ^ _sum(ip + addresses)
    return ip + ip_check.to_bytes(2, "big") + addresses + segment


def is_whole(data: bytes) -> bool:
    """Tell whether both checksums are right."""
    pseudo = data[12:20] + struct.pack("!BBH", 0, data[9], len(data) - 20)
    return _sum(data[:20]) == 0xFFFF and _sum(pseudo + data[20:]) == 0xFFFF


@given(
    protocol=st.sampled_from([UDP, TCP]),
    source=PORTS,
    target=PORTS,
    payload=st.binary(max_size=9),
    new=PORTS,
    is_source=st.booleans(),
)
def test_a_rewritten_packet_is_whole(
    protocol: int, source: Port, target: Port, payload: bytes, new: Port, *, is_source: bool
) -> None:
    """Its other end, its payload and its checksums are right."""
    sent = packet(protocol, source, target, payload)
    assert is_whole(sent)
    got = with_source(sent, new) if is_source else with_target(sent, new)
    assert is_whole(got)
    assert read(got) == ((protocol, new, target) if is_source else (protocol, source, new))
    assert got.endswith(payload)


@given(st.binary(max_size=60))
def test_any_bytes_are_read_or_not(data: bytes) -> None:
    """What is no packet of ours is None."""
    assert read(data) is None or data[0] >> 4 == 4


@pytest.mark.parametrize("protocol", [UDP, TCP])
def test_who_was_spoken_to_may_answer(protocol: int) -> None:
    """By the port of the mapping, and nobody else by it."""
    nat = Nat(PUBLIC, HOST.host, [])
    out = read(nat.outward(packet(protocol, HOST, ROBOT)) or b"")
    assert out is not None
    assert out.source.host == PUBLIC
    assert out.target == ROBOT
    into = read(nat.inward(packet(protocol, ROBOT, out.source)) or b"")
    assert into == (protocol, ROBOT, HOST)
    assert nat.inward(packet(protocol, STRANGER, out.source)) is None
    assert nat.inward(packet(protocol, ROBOT, Port(PUBLIC, 1))) is None


def test_one_socket_has_one_port_outside() -> None:
    """Whoever it speaks to; another socket has another."""
    nat = Nat(PUBLIC, HOST.host, [])
    sources = [
        read(nat.outward(packet(UDP, source, target)) or b"")
        for source, target in ((HOST, ROBOT), (HOST, STRANGER), (Port(HOST.host, 5001), ROBOT))
    ]
    ports = [None if flow is None else flow.source.port for flow in sources]
    assert ports[0] == ports[1] != ports[2]


def test_a_forwarded_port_is_open_to_all() -> None:
    """And what comes from it keeps its number."""
    nat = Nat(PUBLIC, HOST.host, [(UDP, 5000)])
    assert read(nat.inward(packet(UDP, STRANGER, Port(PUBLIC, 5000))) or b"") == (
        UDP,
        STRANGER,
        HOST,
    )
    assert nat.inward(packet(TCP, STRANGER, Port(PUBLIC, 5000))) is None
    out = read(nat.outward(packet(UDP, HOST, STRANGER)) or b"")
    assert out == (UDP, Port(PUBLIC, 5000), STRANGER)


def test_a_router_that_forgets_gives_another_port() -> None:
    """And the old one is closed."""
    nat = Nat(PUBLIC, HOST.host, [])
    old = read(nat.outward(packet(UDP, HOST, ROBOT)) or b"")
    nat.forget()
    new = read(nat.outward(packet(UDP, HOST, ROBOT)) or b"")
    assert old is not None
    assert new is not None
    assert old.source != new.source
    assert nat.inward(packet(UDP, ROBOT, old.source)) is None
