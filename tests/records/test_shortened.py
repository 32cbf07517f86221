"""Addresses are recorded without the person."""

from __future__ import annotations

import pytest

from wax.records.shortened import shortened


@pytest.mark.parametrize(
    ("address", "network"),
    [
        ("192.0.2.77", "192.0.2.0/24"),
        ("::ffff:192.0.2.77", "192.0.2.0/24"),
        ("2001:db8:1:2:3::4", "2001:db8:1::/48"),
        ("2001:db8:1:2::/64", "2001:db8:1::/48"),
        ("fe80::1%eth0", "fe80::/48"),
        ("", ""),
        ("unix:", ""),
    ],
)
def test_an_address_becomes_its_network(address: str, network: str) -> None:
    """IPv4 and IPv6 addresses become a network that is larger than a household."""
    assert shortened(address) == network
