"""The addresses under which the page can be opened, and from which a request comes."""

from __future__ import annotations

import ipaddress
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

import ifaddr

if TYPE_CHECKING:
    from aiohttp import web

_FORWARDED: Final = ("Forwarded", "X-Forwarded-For", "X-Real-IP", "Via")


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


def is_from_here(request: web.Request) -> bool:
    """Tell whether a request was made on the server's own machine.

    Behind a proxy everybody seems to be: what was forwarded, or asked for by another name than
    this machine's own, is from elsewhere.
    """
    if any(name in request.headers for name in _FORWARDED):
        return False
    named = urlsplit(f"//{request.host}").hostname or ""
    return _is_loopback(request.remote or "") and (named == "localhost" or _is_loopback(named))


def sender(request: web.Request) -> str:
    """Return whose request it is, for what is counted by sender: an IPv4 address, an IPv6 /64.

    What a proxy on this machine has forwarded is the last entry's (X-Forwarded-For); from
    elsewhere the header is only what the sender claims.
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
    # One line of a household's or an office's has at least as many (RFC 6177).
    return str(ipaddress.ip_network((ip.packed[:8] + bytes(8), 64)))


def _is_loopback(text: str) -> bool:
    try:
        return ipaddress.ip_address(text).is_loopback
    except ValueError:
        return False
