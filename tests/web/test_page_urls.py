"""The printed addresses can be opened."""

from __future__ import annotations

from types import SimpleNamespace

import ifaddr
import pytest

from wax.web.page_urls import page_urls


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
    """Loopback and link-local addresses are useless to a phone, and are not printed."""
    assert page_urls(host, 80) == urls


def test_under_https() -> None:
    """The printed address has the served scheme."""
    assert page_urls("localhost", 443, "https") == ["https://localhost:443"]
