"""Packets sent together are protected in place and leave in as few calls as their sizes allow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.rtc.egress import MAX_TRAILER_BYTES, Egress, runs

if TYPE_CHECKING:
    from collections.abc import Sequence


class Path:
    """Protects by inverting every bit and adding four bytes; keeps what is sent."""

    def __init__(self) -> None:
        self.sent: list[list[bytes]] = []
        self.is_closed = False

    def protect(self, buffer: bytearray, at: int, size: int, *, is_rtcp: bool) -> int:
        if self.is_closed:
            raise ConnectionError("closed")
        end = at + size
        buffer[at:end] = bytes(255 - one for one in buffer[at:end])
        buffer[end : end + 4] = b"rtcp" if is_rtcp else b"rtp "
        return size + 4

    def send(self, datagrams: memoryview, sizes: Sequence[int]) -> None:
        assert sum(sizes) == len(datagrams)
        found, at = [], 0
        for size in sizes:
            found.append(bytes(datagrams[at : at + size]))
            at += size
        self.sent.append(found)


def protected(packet: bytes, mark: bytes = b"rtp ") -> bytes:
    return bytes(255 - one for one in packet) + mark


@given(st.lists(st.binary(min_size=1, max_size=1400), max_size=12), st.booleans())
def test_packets_leave_in_order_each_protected_once(packets: list[bytes], is_rtcp: bool) -> None:
    """Packets arrive intact and in order, and the returned sizes are those of the datagrams."""
    path = Path()
    sizes = Egress(path).send(packets, is_rtcp=is_rtcp)
    mark = b"rtcp" if is_rtcp else b"rtp "
    assert sizes == [len(packet) + 4 for packet in packets]
    assert path.sent == ([[protected(packet, mark) for packet in packets]] if packets else [])


def test_a_keyframe_larger_than_the_buffer_leaves_in_several_calls() -> None:
    """No packet is lost or sent twice, and no datagram is too large."""
    path = Path()
    packets = [bytes([number]) * 1200 for number in range(130)]
    assert Egress(path).send(packets) == [1204] * 130
    assert len(path.sent) == 3
    assert [one for group in path.sent for one in group] == [protected(one) for one in packets]
    assert all(sum(map(len, group)) <= 65_507 for group in path.sent)
    with pytest.raises(ValueError, match="a packet of"):
        Egress(path).send([bytes(65_507 - MAX_TRAILER_BYTES + 1)])


def test_a_closed_path_raises() -> None:
    """A closed path raises an error, and nothing left in the shared buffer is sent by mistake."""
    path = Path()
    path.is_closed = True
    with pytest.raises(ConnectionError):
        Egress(path).send([b"secret"])
    assert path.sent == []


@given(st.lists(st.integers(1, 4), max_size=40), st.integers(1, 64))
def test_all_sizes_of_a_run_but_the_last_are_equal(sizes: list[int], most: int) -> None:
    """Runs are as long as a kernel can segment: equal sizes, and a last that is no larger."""
    found = runs(sizes, most)
    assert sum(found) == len(sizes)
    at = 0
    for count in found:
        run = sizes[at : at + count]
        assert 1 <= count <= most
        assert len(set(run[:-1])) <= 1
        assert run[-1] <= run[0]
        rest = sizes[at + count :]
        assert not rest or count == most or rest[0] > run[0] or run[-1] < run[0]
        at += count
