"""The addresses of this machine that viewers are offered."""

from __future__ import annotations

import ifaddr
import pytest
from ifaddr import IP, Adapter

from wax.rtc.local_addresses import is_ours, local_addresses

LOOPBACK = Adapter("lo", "lo", [IP("127.0.0.1", 8, "lo"), IP(("::1", 0, 0), 128, "lo")], index=1)
CABLE = Adapter(
    "eth0",
    "eth0",
    [
        IP("192.0.2.7", 24, "eth0"),
        IP(("2001:db8::7", 0, 0), 64, "eth0"),
        IP(("fe80::7", 0, 2), 64, "eth0"),
    ],
    index=2,
)
RADIO = Adapter("wlan0", "wlan0", [IP("198.51.100.7", 24, "wlan0")], index=3)


@pytest.mark.parametrize(
    ("adapters", "chosen", "offered"),
    [
        ([LOOPBACK, CABLE, RADIO], [], ["192.0.2.7", "2001:db8::7", "198.51.100.7"]),
        ([LOOPBACK, CABLE, RADIO], ["wlan0"], ["198.51.100.7"]),
        ([LOOPBACK, CABLE, RADIO], ["2001:db8::7", "lo"], ["127.0.0.1", "::1", "2001:db8::7"]),
        ([LOOPBACK, CABLE], ["wlan0"], []),
        ([LOOPBACK], [], ["127.0.0.1"]),
        ([], [], ["127.0.0.1"]),
    ],
)
def test_the_chosen_ones_are_offered(
    adapters: list[Adapter],
    chosen: list[str],
    offered: list[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All addresses but loopback are offered by default; loopback only if it is alone or chosen."""
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: adapters)
    assert local_addresses(chosen) == offered


def test_own_addresses_are_recognised() -> None:
    """A loopback address is this machine's, a documentation address is not."""
    assert is_ours("127.0.0.1")
    assert not is_ours("192.0.2.1")
