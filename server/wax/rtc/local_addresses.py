"""The addresses of this machine at which viewers may reach it."""

from __future__ import annotations

import ipaddress
import socket
from typing import TYPE_CHECKING

import ifaddr

if TYPE_CHECKING:
    from collections.abc import Collection


def local_addresses(interfaces: Collection[str] = ()) -> list[str]:
    """Return the addresses of these interfaces, given by name or address; by default of all.

    Link-local IPv6 addresses need a scope, which an ICE candidate cannot have. A machine with only
    a loopback interface has 127.0.0.1.
    """
    found = []
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            if not isinstance(ip.ip, str) and ip.ip[2] != 0:
                continue
            address = ip.ip if isinstance(ip.ip, str) else ip.ip[0]
            names = (adapter.name, adapter.nice_name, ip.nice_name, address)
            if interfaces and not any(name in interfaces for name in names):
                continue
            if interfaces or not ipaddress.ip_address(address).is_loopback:
                found.append(address)
    return found or ([] if interfaces else ["127.0.0.1"])


def is_ours(address: str) -> bool:
    """Whether this machine has the address now, loopback included."""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as line:
            line.bind((address, 0))
    except OSError:
        return False
    return True
