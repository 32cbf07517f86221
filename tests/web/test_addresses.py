"""The addresses that are printed can be opened."""

from __future__ import annotations

from types import SimpleNamespace

import ifaddr
import pytest
from aiohttp.test_utils import make_mocked_request

from wax.web.addresses import page_urls, sender


@pytest.fixture(autouse=True)
def _adapters(monkeypatch: pytest.MonkeyPatch) -> None:
    ips = ["127.0.0.1", "192.0.2.7", "169.254.1.1", ("fd00::2", 0, 0), ("fe80::1", 0, 3)]
    adapter = SimpleNamespace(ips=[SimpleNamespace(ip=ip) for ip in ips])
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [adapter])


@pytest.mark.parametrize(
    ("host", "urls"),
    [
        ("localhost", ["http://localhost:80"]),
        ("192.0.2.7", ["http://192.0.2.7:80"]),
        ("::1", ["http://[::1]:80"]),
        ("0.0.0.0", ["http://localhost:80", "http://192.0.2.7:80"]),
        ("::", ["http://localhost:80", "http://192.0.2.7:80", "http://[fd00::2]:80"]),
    ],
)
def test_addresses(host: str, urls: list[str]) -> None:
    """Loopback and link-local addresses are of no use to a phone and are not printed."""
    assert page_urls(host, 80) == urls


@pytest.mark.parametrize(
    ("remote", "forwarded", "expected"),
    [
        ("192.0.2.7", None, "192.0.2.7"),
        ("192.0.2.7", "198.51.100.1", "192.0.2.7"),
        ("127.0.0.1", "198.51.100.1", "198.51.100.1"),
        ("::1", "203.0.113.9, 198.51.100.1", "198.51.100.1"),
        ("127.0.0.1", "nonsense", "127.0.0.1"),
        ("127.0.0.1", None, "127.0.0.1"),
        ("2001:db8:1:2:3:4:5:6", None, "2001:db8:1:2::/64"),
        ("127.0.0.1", "2001:db8:1:2::9", "2001:db8:1:2::/64"),
        ("::ffff:192.0.2.7", None, "192.0.2.7"),
        ("", None, ""),
    ],
)
def test_a_sender_cannot_choose_an_address(
    remote: str, forwarded: str | None, expected: str
) -> None:
    """Only a proxy on this machine is believed, and of what it says only its own entry."""
    headers = {} if forwarded is None else {"X-Forwarded-For": forwarded}
    request = make_mocked_request("POST", "/", headers=headers).clone(remote=remote)
    assert sender(request) == expected
