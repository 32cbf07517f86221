"""The URLs of the page, and the address that a request comes from."""

from __future__ import annotations

import ipaddress
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

import ifaddr

if TYPE_CHECKING:
    from aiohttp import web

_FORWARDED: Final = ("Forwarded", "X-Forwarded-For", "X-Real-IP", "Via")


def page_urls(host: str, port: int) -> list[str]:
    """Return the URLs to open: on this machine, and from a phone on the same network."""
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


def is_from_here(request: web.Request) -> bool:
    """Whether a request was made on the server's own machine.

    Behind a proxy every request seems local: one that was forwarded, or is for a host name other
    than this machine's, counts as remote.
    """
    if any(name in request.headers for name in _FORWARDED):
        return False
    named = urlsplit(f"//{request.host}").hostname or ""
    return _is_loopback(request.remote or "") and (named == "localhost" or _is_loopback(named))


def sender(request: web.Request) -> str:
    """Return the sender of a request, for rate limits: an IPv4 address or an IPv6 /64 prefix.

    For a proxy on this machine it is the last entry of X-Forwarded-For; from elsewhere that header
    is only a claim.
    """
    address = request.remote or ""
    forwarded = ",".join(request.headers.getall("X-Forwarded-For", ()))
    if forwarded and _is_loopback(address):
        address = forwarded.rpartition(",")[2].strip()
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        return request.remote or ""
    if ip.version == 4:
        return str(ip)
    if ip.ipv4_mapped is not None:
        return str(ip.ipv4_mapped)
    # One household or office has at least a /64 (RFC 6177).
    return str(ipaddress.ip_network((ip.packed[:8] + bytes(8), 64)))


def _is_loopback(text: str) -> bool:
    try:
        return ipaddress.ip_address(text).is_loopback
    except ValueError:
        return False
