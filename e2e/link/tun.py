"""TUN devices: a network interface whose packets a process reads and writes."""

from __future__ import annotations

import fcntl
import os
import struct
from typing import Final

from e2e.measure.errors import NotRunError

DEVICE: Final = "/dev/net/tun"
_TUNSETIFF: Final = 0x400454CA  # linux/if_tun.h, as x86 and ARM number it
_IFF_TUN: Final = 0x0001
_IFF_NO_PI: Final = 0x1000
_READ_BYTES: Final = 2048
"""More than the MTU; a packet is read whole or its end is gone."""


def open_tun(name: str) -> int:
    """Make the device `name` in this process's network namespace; it goes when this is closed.

    Return a descriptor that does not block and gives IP packets. Raises `NotRunError`.
    """
    try:
        descriptor = os.open(DEVICE, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    except PermissionError as error:
        raise NotRunError(
            f"{DEVICE} may not be opened by this user; run as root or let users read and write it"
        ) from error
    except OSError as error:
        raise NotRunError(
            f"{DEVICE} is missing; load the kernel module tun, or give the container that device"
        ) from error
    try:
        request = struct.pack("16sH22x", name.encode("ascii"), _IFF_TUN | _IFF_NO_PI)
        fcntl.ioctl(descriptor, _TUNSETIFF, request)
    except OSError as error:
        os.close(descriptor)
        raise NotRunError(
            f"no TUN device can be made here ({error.strerror}); run as root or give the "
            "container the capability NET_ADMIN"
        ) from error
    return descriptor


def read_packets(descriptor: int, limit: int) -> list[bytes]:
    packets: list[bytes] = []
    try:
        while len(packets) < limit:
            packets.append(os.read(descriptor, _READ_BYTES))
    except BlockingIOError:
        pass
    return packets
