"""Of an offer's candidates, those are kept at which its sender may be."""

from __future__ import annotations

from ipaddress import ip_address

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.rtc.steps import counted

from wax.rtc.candidates import MAX_CANDIDATES, without_unwanted

WORLD = "203.0.113.9"
LAN = "192.168.1.20"
HERE = "127.0.0.1"


def line(address: str, *, transport: str = "udp") -> str:
    return f"a=candidate:1 1 {transport} 2113937151 {address} 54597 typ host generation 0"


def kept(address: str, sender: str | None) -> bool:
    return without_unwanted(["a=mid:0", line(address), "a=x"], sender) == [
        "a=mid:0",
        line(address),
        "a=x",
    ]


@pytest.mark.parametrize(
    "address", ["198.51.100.4", "2001:db8::4", "::ffff:198.51.100.4", "8.8.8.8"]
)
@pytest.mark.parametrize("sender", [None, "", "nonsense", WORLD, LAN, HERE, "2001:db8::/64"])
def test_public_addresses_are_kept(address: str, sender: str | None) -> None:
    """Public addresses are kept, of which a viewer may have several and a relay."""
    assert kept(address, sender)


@pytest.mark.parametrize(
    "address",
    [
        *("224.0.0.251", "ff02::fb", "0.0.0.0", "0.1.2.3", "::", "255.255.255.255", "240.0.0.1"),
        *("1f4712db-ea17-4bcf-a596-105139dfd8bf.local", "localhost", "", "1.2.3"),
        "::ffff:224.0.0.1",
    ],
)
@pytest.mark.parametrize("sender", [None, WORLD, LAN, HERE])
def test_multicast_reserved_and_named_addresses_are_dropped(
    address: str, sender: str | None
) -> None:
    """Multicast, which multiplies packets, and names, which need a lookup, are dropped."""
    assert not kept(address, sender)


@pytest.mark.parametrize(
    ("address", "sender", "is_kept"),
    [
        ("192.168.1.1", LAN, True),
        ("::ffff:192.168.1.1", LAN, True),
        ("192.168.1.1", "::ffff:192.168.7.7", True),
        ("192.168.1.1", WORLD, False),
        ("192.168.1.1", None, False),
        ("10.0.0.1", LAN, False),
        ("10.0.0.1", "10.9.9.9", True),
        ("172.16.0.1", "172.31.0.1", True),
        ("172.32.0.1", WORLD, True),
        ("100.64.0.1", WORLD, False),
        ("169.254.169.254", WORLD, False),
        ("fd00::1", "fd00:0:0:1::/64", True),
        ("fd00::1", "2001:db8::/64", False),
        ("fe80::1", WORLD, False),
        ("127.0.0.1", WORLD, False),
        ("127.0.0.1", LAN, False),
        ("::1", LAN, False),
        ("127.0.0.1", HERE, True),
        ("::1", HERE, True),
        ("10.0.0.1", HERE, True),
        ("fd00::1", "::1/128", True),
    ],
)
def test_local_addresses_are_kept_for_local_senders(
    address: str, sender: str, *, is_kept: bool
) -> None:
    """Local addresses are kept only for senders in that network: strangers cannot probe it."""
    assert kept(address, sender) == is_kept


def test_there_are_at_most_sixteen() -> None:
    """At most sixteen candidates are kept, and the rest of the offer stays in order."""
    lines = [text for n in range(560) for text in (f"a=x{n}", line(f"198.51.100.{n % 256}"))]
    cleaned = without_unwanted(lines, None)
    assert sum(one.startswith("a=candidate") for one in cleaned) == MAX_CANDIDATES == 16
    assert cleaned[:32] == lines[:32]
    assert cleaned[32:] == lines[32::2]


def test_unusable_candidates_do_not_count() -> None:
    """Names, TCP and incomplete lines do not count towards the limit."""
    unwanted = [line("a.local"), line("198.51.100.4", transport="tcp"), "a=candidate:", line("::")]
    wanted = [line(f"198.51.100.{n}") for n in range(16)]
    assert without_unwanted(unwanted * 10 + wanted, None) == wanted


def test_of_hundreds_a_few_are_read() -> None:
    """What an address costs to parse is paid for 64 lines, however many an offer has."""
    unwanted = [line(f"ff02:1:1:1:1:1:1:{n:x}") for n in range(1000)]
    with counted() as steps:
        assert without_unwanted([*unwanted, line("198.51.100.4"), "a=x"], None) == ["a=x"]
    assert steps.count < 100_000


@given(st.lists(st.text() | st.ip_addresses().map(str).map(line)), st.none() | st.text())
def test_no_lines_raise(lines: list[str], sender: str | None) -> None:
    """Any lines are filtered to a subsequence without an error or a multicast candidate."""
    cleaned = without_unwanted(lines, sender)
    rest = iter(lines)
    assert all(one in rest for one in cleaned)  # a subsequence
    for one in cleaned:
        if one.startswith("a=candidate:"):
            address = ip_address(one.split()[4])
            assert not address.is_multicast
            assert not address.is_unspecified
