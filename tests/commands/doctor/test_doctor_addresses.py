"""Addresses: local, public, carrier-grade NAT; as a STUN server sees them; firewalls."""

from __future__ import annotations

import ipaddress
import socket
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest
from aioice import stun

from wax.commands.doctor import addresses
from wax.rtc import stun_query
from wax.rtc.stun_query import StunError, public_address, split

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from tests.commands.doctor.conftest import MakeNetwork


def _own(*pairs: tuple[str, str]) -> list[tuple[str, addresses.Address]]:
    return [(name, ipaddress.ip_address(address)) for name, address in pairs]


@pytest.mark.parametrize(
    ("own", "level", "says"),
    [
        ([("eth0", "192.168.1.7")], "ok", "must forward TCP port 8080 and UDP port 8081"),
        ([("eth0", "93.184.215.14")], "ok", "public address"),
        ([("eth0", "192.168.1.7"), ("eth0", "2606:2800:21f::1")], "ok", "public address"),
        ([("wwan0", "100.72.3.4")], "warning", "shares its address"),
        ([("tailscale0", "100.72.3.4"), ("eth0", "10.0.0.2")], "ok", "must forward"),
        ([], "bad", "no address"),
    ],
)
def test_the_kind_of_address_decides(
    network: MakeNetwork, own: list[tuple[str, str]], level: str, says: str
) -> None:
    """The verdict depends on whether an address is public, private, shared, a VPN's or missing."""
    verdict = addresses.local_addresses(network(), _own(*own))
    assert (verdict.level, says in verdict.sentence) == (level, True), verdict


def test_a_page_on_loopback_is_for_this_machine(network: MakeNetwork) -> None:
    """A page on loopback is reported as private, whatever addresses there are."""
    verdict = addresses.local_addresses(network(host="localhost"), _own(("eth0", "10.0.0.2")))
    assert (verdict.level, "--host" in verdict.advice) == ("warning", True)


def test_an_interface_that_is_missing_is_told(network: MakeNetwork) -> None:
    """A configured interface without an address is reported."""
    ours = network(interfaces=("wlan0", "eth0"))
    verdict = addresses.local_addresses(ours, _own(("eth0", "10.0.0.2")))
    assert (verdict.level, "no interface wlan0" in verdict.sentence) == ("bad", True)


def test_behind_a_proxy_its_port_is_forwarded(network: MakeNetwork) -> None:
    """Behind a proxy, loopback is fine, and the router must forward the proxy's port."""
    ours = network(host="localhost", is_behind_proxy=True)
    verdict = addresses.local_addresses(ours, _own(("eth0", "10.0.0.2")))
    assert (verdict.level, "TCP port 443 and UDP port 8081" in verdict.sentence) == ("ok", True)


def test_own_addresses_leave_this_machine() -> None:
    """Own addresses include neither loopback nor link-local ones."""
    assert not [a for _, a in addresses.own_addresses() if a.is_loopback or a.is_link_local]


# --- STUN ------------------------------------------------------------------------------------


def _sees(address: str) -> Callable[[bytes], list[bytes]]:
    """Return the answer of a STUN server that sees this address."""

    def answer(data: bytes) -> list[bytes]:
        request = stun.parse_message(data)
        assert (request.message_method, request.message_class) == (
            stun.Method.BINDING,
            stun.Class.REQUEST,
        )
        return [_response(request.transaction_id, address)]

    return answer


def _response(transaction_id: bytes, address: str) -> bytes:
    response = stun.Message(stun.Method.BINDING, stun.Class.RESPONSE, transaction_id)
    response.attributes["XOR-MAPPED-ADDRESS"] = (address, 40_000)
    return bytes(response)


@contextmanager
def _server(answer: Callable[[bytes], list[bytes]]) -> Iterator[str]:
    """Run a STUN server; yields its address as ``HOST:PORT``."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        line.settimeout(0.02)
        stopping = threading.Event()

        def serve() -> None:
            while not stopping.is_set():
                try:
                    data, sender = line.recvfrom(1500)
                except TimeoutError:
                    continue
                for one in answer(data):
                    line.sendto(one, sender)

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"127.0.0.1:{line.getsockname()[1]}"
        stopping.set()
        thread.join()


@pytest.mark.parametrize(
    ("announced", "own", "level", "says"),
    [
        ((), "93.184.215.14", "ok", "its own address"),
        ((), "10.0.0.2", "warning", "the address of a router"),
        (("93.184.215.14",), "10.0.0.2", "ok", "as viewers are told"),
        (("203.0.113.5",), "10.0.0.2", "bad", "are told 203.0.113.5"),
    ],
)
def test_what_the_world_sees_is_compared(
    network: MakeNetwork, announced: tuple[str, ...], own: str, level: str, says: str
) -> None:
    """The address seen is compared with our own and with the one that viewers get."""
    with _server(_sees("93.184.215.14")) as server:
        ours = network(stun=(server,), public_addresses=announced)
        verdict = addresses.world_address(ours, _own(("eth0", own)))
    assert (verdict.level, says in verdict.sentence) == (level, True), verdict
    assert "93.184.215.14" in verdict.sentence


def test_a_second_server_stands_in_for_the_first(
    network: MakeNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A silent or invalid STUN server is skipped; if all are, the verdict is bad."""
    others = (b"", b"junk" * 9, _response(bytes(12), "192.0.2.1"))
    with (
        _server(lambda _: []) as silent,
        _server(lambda _: list(others)) as wrong,
        _server(_sees("93.184.215.14")) as right,
    ):

        def ask(server: str) -> str:
            """Wait without a limit only for the server that answers."""
            tries_s = (10.0,) if server == right else (0.02, 0.02)
            monkeypatch.setattr(stun_query, "_TRIES_S", tries_s)
            return public_address(server)

        monkeypatch.setattr(addresses, "public_address", ask)
        ours = network(stun=(silent, wrong, right))
        assert "93.184.215.14" in addresses.world_address(ours, []).sentence
        verdict = addresses.world_address(network(stun=(silent, wrong)), [])
    assert (verdict.level, "does not answer" in verdict.sentence) == ("bad", True)


def test_nobody_is_asked_unless_configured(network: MakeNetwork) -> None:
    """Without a configured STUN server there is a hint and no traffic."""
    assert "--stun" in addresses.world_address(network(), []).sentence
    told = addresses.world_address(network(public_addresses=("203.0.113.5",)), [])
    assert (told.level, "203.0.113.5" in told.sentence) == ("ok", True)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("stun.example.org", ("stun.example.org", 3478)),
        ("192.0.2.1:19302", ("192.0.2.1", 19302)),
        ("[2001:db8::1]:3479", ("2001:db8::1", 3479)),
        ("[2001:db8::1]", ("2001:db8::1", 3478)),
    ],
)
def test_a_server_is_written_as_usual(text: str, parts: tuple[str, int]) -> None:
    """A STUN server's port is optional, and an IPv6 address has brackets."""
    assert split(text) == parts


@pytest.mark.parametrize(
    "text", [":1", "host:", "host:x", "host:0", "host:65536", "no.such.invalid"]
)
def test_a_server_that_is_none_is_a_sentence(text: str) -> None:
    """An invalid address or an unknown name is a sentence."""
    with pytest.raises(StunError, match=r"STUN server") as refused:
        public_address(text)
    if text == "no.such.invalid":
        assert "asked. The name no.such.invalid " in str(refused.value)


# --- firewalls -------------------------------------------------------------------------------


@pytest.fixture
def etc(tmp_path: Path) -> dict[str, Path]:
    """Return the paths of three firewalls' files, none of which exists."""
    return {name: tmp_path / name for name in ("ufw", "firewalld", "nftables")}


def test_no_firewall_is_well(network: MakeNetwork, etc: dict[str, Path]) -> None:
    """Without a firewall, the verdict is ok."""
    etc["ufw"].mkdir()
    (etc["ufw"] / "ufw.conf").write_text("ENABLED=no\n")
    assert addresses.firewall(network(), **etc).level == "ok"


def test_ufw_is_asked_for_its_rules(network: MakeNetwork, etc: dict[str, Path]) -> None:
    """The commands for ports that ufw blocks are printed; if none is blocked, it is ok."""
    etc["ufw"].mkdir()
    (etc["ufw"] / "ufw.conf").write_text("# ufw\nENABLED=yes\n")
    rules = etc["ufw"] / "user.rules"
    shut = addresses.firewall(network(), **etc)
    assert "sudo ufw allow 8080/tcp && sudo ufw allow 8081/udp" in shut.advice
    rules.write_text("### tuple ### allow tcp 8080 0.0.0.0/0 any 0.0.0.0/0 in\n")
    half = addresses.firewall(network(), **etc)
    assert (half.level, half.advice) == ("warning", "Type `sudo ufw allow 8081/udp`.")
    rules.write_text(rules.read_text() + "### tuple ### allow any 8081 0.0.0.0/0 any ::/0 in\n")
    assert addresses.firewall(network(), **etc).level == "ok"


@pytest.mark.parametrize("name", ["firewalld", "nftables"])
def test_other_firewalls_are_told(network: MakeNetwork, etc: dict[str, Path], name: str) -> None:
    """Another active firewall is a warning that names the ports to open."""
    etc[name].write_text("1")
    verdict = addresses.firewall(network(), **etc)
    assert (verdict.level, "8080" in verdict.advice, "8081" in verdict.advice) == (
        "warning",
        True,
        True,
    )
