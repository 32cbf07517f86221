"""The addresses under which the page can be opened, and who opens it on this very machine."""

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


def _is_loopback(text: str) -> bool:
    try:
        return ipaddress.ip_address(text).is_loopback
    except ValueError:
        return False
