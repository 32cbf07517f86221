"""Who sent a request, and how their browser sees us; of proxies only trusted ones are believed."""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.config.host_spelling import DEFAULT_PORTS
from wax.errors import NotForUsError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from aiohttp import web

    Address = ipaddress.IPv4Address | ipaddress.IPv6Address

_SCHEMES: Final = {"http": "http", "https": "https", "ws": "http", "wss": "https"}
"""What proxies say, and what a browser has in the origin of the page that asks."""
_FOR: Final = re.compile(r'(?i)\bfor="?([^",;]*)')
_TWO_SENDERS: Final = Sentence("request.two_senders")


@dataclass(frozen=True, slots=True)
class Seen:
    """A request as its sender sees it.

    `sender` is an IPv4 address or an IPv6 /64 prefix, for limits, empty if there is none; `host` is
    what the browser has as host and port, unchecked, empty if it says nothing.
    """

    sender: str
    scheme: str
    host: str

    @property
    def name(self) -> str:
        """The name without its port; not for an IPv6 address."""
        return self.host.lower().partition(":")[0]

    @property
    def origin(self) -> str:
        """The origin of our page in this browser (RFC 6454, 6.2)."""
        return f"{self.scheme}://{self.host.removesuffix(DEFAULT_PORTS[self.scheme])}".lower()


class Proxies:
    """The trusted proxies, as addresses or networks; raises `ValueError` for anything else."""

    def __init__(self, trusted: Iterable[str]) -> None:
        self._trusted = [ipaddress.ip_network(one, strict=False) for one in trusted]

    def trusts(self, text: str) -> bool:
        """Whether an address is that of a trusted proxy."""
        address = parsed(text)
        return address is not None and self._trusts(address)

    def seen(self, request: web.Request) -> Seen:
        """Return a request as its sender sees it, through any number of trusted proxies.

        Both families of headers count, X-Forwarded-For/-Proto/-Host and Forwarded (RFC 7239). A
        proxy sets one and may pass on what a client forged in the other: where they differ, one is
        forged, and `NotForUsError` is raised. A proxy that adds none is the sender itself.
        """
        direct = self.direct(request)
        remote = parsed(request.remote or "")
        if remote is None or not self._trusts(remote):
            return direct
        found = [
            self._forwarded(request, remote, direct),
            self._x_forwarded(request, remote, direct),
        ]
        claims = [one for one in found if one is not None]
        if any(one.sender != claims[0].sender for one in claims):
            raise NotForUsError(_TWO_SENDERS, 400)
        return claims[0] if claims else direct

    def direct(self, request: web.Request) -> Seen:
        """Return a request as if whoever is at the other end of the connection had sent it."""
        host = ",".join(request.headers.getall("Host", ()))
        return Seen(limited(request.remote or ""), request.scheme, host)

    def sender(self, remote: str, x_forwarded_for: Sequence[str], forwarded: Sequence[str]) -> str:
        """Return for whom a head comes, as `seen` does where that is clear; the proxy where not."""
        address = parsed(remote)
        if address is None or not self._trusts(address):
            return limited(remote)
        entries = _split(x_forwarded_for) or _FOR.findall(",".join(forwarded))
        return _limited(self._walk(address, entries)[0])

    def _x_forwarded(self, request: web.Request, remote: Address, direct: Seen) -> Seen | None:
        senders, schemes, hosts = (
            _values(request, f"X-Forwarded-{name}") for name in ("For", "Proto", "Host")
        )
        if not senders and not schemes and not hosts:
            return None
        sender, hops = self._walk(remote, senders)
        # Proxies that are not listed add to it, too. Whoever lies about it, about their own
        # connection, deceives nobody but themselves; no page can make a browser do so.
        scheme = schemes[0] if schemes else ""
        return _believed(sender, scheme, _outermost(hosts, hops), direct)

    def _forwarded(self, request: web.Request, remote: Address, direct: Seen) -> Seen | None:
        elements = request.forwarded
        if not elements:
            return None
        sender, hops = self._walk(remote, [one.get("for", "") for one in elements])
        outermost = elements[-min(hops, len(elements))]
        return _believed(sender, outermost.get("proto", ""), outermost.get("host", ""), direct)

    def _walk(self, remote: Address, entries: Sequence[str]) -> tuple[Address, int]:
        """Return the last address that is none of our proxies', and how many of them passed it on.

        What is left of it was said by the sender, who may say anything.
        """
        sender, hops = remote, 0
        for entry in reversed(entries):
            if not self._trusts(sender):
                break
            hops += 1
            if (address := parsed(entry)) is None:
                break
            sender = address
        return sender, max(hops, 1)

    def _trusts(self, address: Address) -> bool:
        return any(address.version == one.version and address in one for one in self._trusted)


def parsed(text: str) -> Address | None:
    """Read an address as sockets and proxies write it, zone or port included; None if not one."""
    text = text.strip().strip('"')
    if text.startswith("["):
        text = text[1:].partition("]")[0]
    elif text.count(":") == 1:
        text = text.partition(":")[0]
    try:
        address = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    if address.version == 6 and address.ipv4_mapped is not None:
        return address.ipv4_mapped
    return address


def limited(text: str) -> str:
    """Return what limits count an address as: an IPv4 address or an IPv6 /64 prefix."""
    address = parsed(text)
    return "" if address is None else _limited(address)


def is_same_site(request: web.Request) -> bool:
    """Whether a browser says that our own page asks, or nothing about it (Fetch Metadata)."""
    sites = request.headers.getall("Sec-Fetch-Site", ())
    return all(site in ("same-origin", "none") for site in sites)


def is_same_origin(request: web.Request, origin: str) -> bool:
    """Whether a request comes from our own page, or from a program that is no browser.

    A browser says where a page is from with everything that changes state (Fetch, 3.1; Fetch
    Metadata). A program could claim anything, but has no cookie that somebody else was given.
    """
    origins = request.headers.getall("Origin", ())
    return is_same_site(request) and all(one.lower() == origin for one in origins)


def _believed(sender: Address, scheme: str, host: str, direct: Seen) -> Seen:
    return Seen(_limited(sender), _SCHEMES.get(scheme.lower(), direct.scheme), host or direct.host)


def _values(request: web.Request, name: str) -> list[str]:
    return _split(request.headers.getall(name, ()))


def _split(values: Sequence[str]) -> list[str]:
    joined = ",".join(values)
    return [value.strip() for value in joined.split(",")] if joined.strip() else []


def _outermost(values: Sequence[str], hops: int) -> str:
    """Return what the outermost trusted proxy said: they append, or replace what there is."""
    return values[-min(hops, len(values))] if values else ""


def _limited(address: Address) -> str:
    # One household or office has at least a /64 (RFC 6177).
    if address.version == 4:
        return str(address)
    return str(ipaddress.ip_network((address.packed[:8] + bytes(8), 64)))
