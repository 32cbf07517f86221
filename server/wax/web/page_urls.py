"""The URLs of the page, and which addresses are the loopback's."""

from __future__ import annotations

import ipaddress

import ifaddr


def page_urls(host: str, port: int, scheme: str = "http") -> list[str]:
    """Return the URLs to open: on this machine, and from a phone on the same network."""
    if host not in ("0.0.0.0", "::", ""):
        return [f"{scheme}://{_literal(host)}:{port}"]
    found = [
        address
        for adapter in ifaddr.get_adapters()
        for ip in adapter.ips
        if (address := _usable(ip.ip if isinstance(ip.ip, str) else ip.ip[0])) is not None
    ]
    wanted = [a for a in found if host == "::" or a.version == 4]
    return [
        f"{scheme}://localhost:{port}",
        *(f"{scheme}://{_literal(str(a))}:{port}" for a in wanted),
    ]


def _usable(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    address = ipaddress.ip_address(text)
    return None if address.is_loopback or address.is_link_local else address


def _literal(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def is_loopback(text: str) -> bool:
    """Whether an address is the loopback's."""
    try:
        return ipaddress.ip_address(text).is_loopback
    except ValueError:
        return False
