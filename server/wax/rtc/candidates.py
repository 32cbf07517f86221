"""Filters an offer's candidates: full ICE sends packets to each address that it checks. Pure.

An offer could name strangers, or machines in the server's own network that its sender cannot reach.
Removing a candidate costs no connection: the browser's own checks reveal its address
(peer-reflexive, RFC 8445 7.3.1.3).
"""

from __future__ import annotations

from ipaddress import IPv4Address, IPv6Address, ip_address, ip_network
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable

MAX_CANDIDATES: Final = 16
"""A browser has a handful, or a dozen with several networks and a relay."""
_MOST_READ: Final = 64
"""In all sections together, at 10 µs each; those behind them are removed unread."""

_PREFIX: Final = "a=candidate:"
_LEAST_PARTS: Final = 8
"""foundation, component, transport, priority, address, port, "typ" and type (RFC 8839, 5.1)."""

_LOCAL: Final = tuple(
    ip_network(text)
    for text in (
        "10.0.0.0/8",
        "100.64.0.0/10",
        "169.254.0.0/16",
        "172.16.0.0/12",
        "192.168.0.0/16",
        "fc00::/7",
        "fe80::/10",
    )
)
"""Private, shared and link-local (RFC 1918, 6598, 3927, 4193, 4291)."""
_NOBODY: Final = (ip_network("0.0.0.0/8"), ip_network("240.0.0.0/4"))
"""The "this" network, and the reserved range with the broadcast address (RFC 1122, 1112)."""

_Ip = IPv4Address | IPv6Address


def without_unwanted(lines: Iterable[str], sender: str | None) -> list[str]:
    """Return the lines without unwanted candidates, and with `MAX_CANDIDATES` at most.

    `sender` is the address that the offer came from, or its network; None if it is unknown. A UDP
    candidate is wanted if its address is public or in the sender's own private network. A sender on
    this machine may name any local address.
    """
    home = _home(sender)
    kept = []
    left, unread = MAX_CANDIDATES, _MOST_READ
    for line in lines:
        if line.startswith(_PREFIX):
            unread -= 1
            if left == 0 or unread < 0 or not _is_wanted(line, home):
                continue
            left -= 1
        kept.append(line)
    return kept


def _is_wanted(line: str, home: _Ip | None) -> bool:
    parts = line.removeprefix(_PREFIX).split()
    if len(parts) < _LEAST_PARTS or parts[2].lower() != "udp":
        return False
    try:
        address = _unmapped(ip_address(parts[4]))
    except ValueError:  # a name: mDNS names cannot be resolved without multicast
        return False
    if address.is_multicast or address.is_unspecified or any(address in one for one in _NOBODY):
        return False
    is_here = home is not None and home.is_loopback
    if address.is_loopback:
        return is_here
    network = next((one for one in _LOCAL if address in one), None)
    return network is None or is_here or (home is not None and home in network)


def _home(sender: str | None) -> _Ip | None:
    try:
        return _unmapped(ip_network(sender or "", strict=False).network_address)
    except ValueError:
        return None


def _unmapped(address: _Ip) -> _Ip:
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None
    return mapped or address
