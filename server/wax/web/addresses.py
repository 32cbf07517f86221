"""The addresses under which the page can be opened."""

from __future__ import annotations

import ipaddress

import ifaddr


def page_urls(host: str, port: int) -> list[str]:
    """Return what to type into a browser: here, and from a phone in the same network."""
    if host not in ("0.0.0.0", "::", ""):
        return [f"http://{_literal(host)}:{port}"]
    found = [
        address
        for adapter in ifaddr.get_adapters()
        for ip in adapter.ips
        if (address := _usable(ip.ip if isinstance(ip.ip, str) else ip.ip[0])) is not None
    ]
    wanted = [a for a in found if host == "::" or a.version == 4]
    return [f"http://localhost:{port}", *(f"http://{_literal(str(a))}:{port}" for a in wanted)]


def _usable(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    address = ipaddress.ip_address(text)
    return None if address.is_loopback or address.is_link_local else address


def _literal(host: str) -> str:
    return f"[{host}]" if ":" in host else host
