"""Shortens addresses for records and console to a network, not a household. Pure."""

from __future__ import annotations

import ipaddress
from functools import lru_cache
from typing import Final

_V4_BITS: Final = 24
_V6_BITS: Final = 48
"""The prefix lengths of about 250 IPv4 households, and of one IPv6 site (RFC 6177)."""


@lru_cache(maxsize=1024)  # the host's console asks for everybody's each second
def shortened(address: str) -> str:
    """Return the network of an address or of a prefix; "" for anything else."""
    try:
        ip = ipaddress.ip_interface(address.partition("%")[0]).ip
    except ValueError:
        return ""
    if ip.version == 6 and ip.ipv4_mapped is not None:
        ip = ip.ipv4_mapped
    bits = _V4_BITS if ip.version == 4 else _V6_BITS
    return str(ipaddress.ip_network((ip.packed, bits), strict=False))
