"""Protects one peer's media in place (SRTP) and sends it, without a coroutine.

A picture's packets are written back to back into one buffer and leave in as few system calls as the
path allows. Nothing here depends on aiortc.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

MAX_TRAILER_BYTES: Final = 144
"""The most that protecting adds to a packet (libsrtp's SRTP_MAX_TRAILER_LEN and its RTCP index)."""
_BUFFER_BYTES: Final = 65_507
"""The most that one UDP datagram, and so one call, can carry over IPv4 (RFC 768, RFC 791)."""


class MediaTransport(Protocol):
    """The SRTP keys and the network path of one peer."""

    def protect(self, buffer: bytearray, at: int, size: int, *, is_rtcp: bool) -> int:
        """Protect the packet of `size` bytes at `at` in place; return its new size.

        Raises `ConnectionError` once the transport is closed.
        """
        ...

    def send(self, datagrams: memoryview, sizes: Sequence[int]) -> None:
        """Send datagrams stored back to back; raises `ConnectionError` once closed."""
        ...


_buffer = bytearray(_BUFFER_BYTES)
"""Shared by all peers: they send from one thread, and sends never nest."""
_view = memoryview(_buffer)


class Egress:
    """Sends a group of packets in as few calls as possible."""

    def __init__(self, transport: MediaTransport) -> None:
        self._transport = transport

    def send(self, packets: Sequence[bytes], *, is_rtcp: bool = False) -> list[int]:
        """Protect and send RTP packets, or RTCP compounds; return the size of each datagram.

        Raises `ConnectionError` once the transport is closed, and `ValueError` for a packet that no
        datagram can carry.
        """
        sizes: list[int] = []
        first = at = 0
        for packet in packets:
            end = at + len(packet)
            if end + MAX_TRAILER_BYTES > _BUFFER_BYTES:
                self._transport.send(_view[:at], sizes[first:])
                first, at, end = len(sizes), 0, len(packet)
                if end + MAX_TRAILER_BYTES > _BUFFER_BYTES:
                    raise ValueError(f"a packet of {end} bytes")
            _buffer[at:end] = packet
            size = self._transport.protect(_buffer, at, len(packet), is_rtcp=is_rtcp)
            sizes.append(size)
            at += size
        if at:
            self._transport.send(_view[:at], sizes[first:])
        return sizes


def runs(sizes: Sequence[int], most: int) -> list[int]:
    """Group sizes into the fewest runs that UDP segmentation offload can send in one call.

    All sizes of a run are equal, but the last may be smaller. Returns the length of each run, 1 to
    `most`.
    """
    found: list[int] = []
    size, is_open = 0, False
    for one in sizes:
        if is_open and one <= size and found[-1] < most:
            found[-1] += 1
            is_open = one == size
        else:
            found.append(1)
            size, is_open = one, True
    return found
