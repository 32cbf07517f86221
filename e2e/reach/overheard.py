"""``python -m e2e.reach.overheard RELAY``: prints when each command reaches this host by a relay.

The times are the kernel's, on the clock of `time.monotonic`, so that this process delays none.
"""

from __future__ import annotations

import socket
import struct
import sys
import time
from typing import Final

from e2e.stop.relay import is_command

_ETH_P_IP: Final = 0x0800
_SO_TIMESTAMPNS: Final = 35
_UDP: Final = 17
_TURN_PORT: Final = 3478
_CHANNELS: Final = range(0x4000, 0x5000)
"""The channel numbers that begin ChannelData (RFC 8656, 12)."""


def relayed(packet: bytes, relay: bytes) -> bytes:
    """Return what the relay forwards in this IPv4 packet; empty if it is not the relay's."""
    udp = packet[4 * (packet[0] & 15) :]
    if packet[9] != _UDP or packet[12:16] != relay or len(udp) < 12:
        return b""
    port, channel, length = struct.unpack_from("!H6xHH", udp)
    return udp[12 : 12 + length] if port == _TURN_PORT and channel in _CHANNELS else b""


def main() -> None:
    relay = socket.inet_aton(sys.argv[1])
    with socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(_ETH_P_IP)) as line:
        line.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
        while True:
            packet, [(_, _, stamp)], *_ = line.recvmsg(2048, socket.CMSG_SPACE(16))
            if is_command(relayed(packet, relay)):
                seconds, nanoseconds = struct.unpack("@qq", stamp)
                ago_ns = time.time_ns() - seconds * 10**9 - nanoseconds
                print(time.monotonic() - ago_ns / 1e9, flush=True)


if __name__ == "__main__":
    main()
