"""Which hosts are this server, and which are not."""

from __future__ import annotations

import socket
from types import SimpleNamespace

import ifaddr
import pytest
from tests.web.foreign import FOREIGN_HOSTS, MALFORMED_HOSTS

from wax.web.host_names import HostNames, host_of


@pytest.fixture
def names(monkeypatch: pytest.MonkeyPatch) -> HostNames:
    ips = ["127.0.0.1", "192.0.2.7", ("fd00::2", 0, 0), ("fe80::1%eth0", 0, 3)]
    adapter = SimpleNamespace(ips=[SimpleNamespace(ip=ip) for ip in ips])
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [adapter])
    monkeypatch.setattr(socket, "gethostname", lambda: "Robot")
    return HostNames(["robots.example"])


@pytest.mark.parametrize("text", MALFORMED_HOSTS)
def test_malformed_hosts_are_refused(text: str) -> None:
    """So is whatever RFC 3986 does not allow there, even if some programs accept it."""
    with pytest.raises(ValueError, match=r"."):
        host_of(text)


@pytest.mark.parametrize("text", FOREIGN_HOSTS)
def test_foreign_hosts_are_not_ours(text: str, names: HostNames) -> None:
    """These are other names, other forms of addresses, and names that only contain ours."""
    assert not names.knows(host_of(text), 0.0)


@pytest.mark.parametrize(
    "text",
    [
        "localhost",
        "LOCALHOST:8080",
        "localhost.",
        "127.0.0.1:8080",
        "[::1]:8080",
        "[0:0:0:0:0:0:0:1]",
        "192.0.2.7",
        "[fd00::2]:8080",
        "[FE80::1]",
        "robot",
        "robot.local:8080",
        "Robot.Local",
        "robots.example",
    ],
)
def test_our_own_hosts(text: str, names: HostNames) -> None:
    """Configured names and this machine's own are known, however they are written."""
    assert names.knows(host_of(text), 0.0)


@pytest.mark.parametrize("text", ["xn--mller-kva.example:8080", "M\xdcLLER.example"])
def test_an_international_name_is_ours(text: str, names: HostNames) -> None:
    """It counts as browsers encode it, and in its own letters, as other programs send it."""
    assert not names.knows(host_of(text), 0.0)
    assert HostNames(["xn--mller-kva.example"]).knows(host_of(text), 0.0)


def test_a_new_address_is_found(names: HostNames, monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine is known by its new address; it looks them up at most once a second."""
    looked = []

    def adapters() -> list[SimpleNamespace]:
        looked.append(1)
        return [SimpleNamespace(ips=[SimpleNamespace(ip="198.51.100.4")])]

    monkeypatch.setattr(ifaddr, "get_adapters", adapters)
    assert names.knows("198.51.100.4", 1.0)
    for _ in range(100):
        assert not names.knows("198.51.100.5", 1.5)
        assert not names.knows("evil.example", 9.0)
    assert len(looked) == 1
    assert not names.knows("192.0.2.7", 2.5)
    assert len(looked) == 2
