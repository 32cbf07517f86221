"""Who sent a request, and how they address us; only trusted proxies are believed."""

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
"""The schemes that proxies report, and those in the origin that a browser sends."""
_ABOUT_SENDERS: Final = "Forwarded", "X-Forwarded-For", "X-Forwarded-Proto", "X-Forwarded-Host"
_FOR: Final = re.compile(r'(?i)\bfor="?([^",;]*)')
_TWO_SENDERS: Final = Sentence("request.two_senders")
_MOST_CHARS: Final = 1024
"""How much of a header about the sender is read: a client may add to it, and parsing takes time."""
_TOO_LONG: Final = Sentence("request.too_large")


@dataclass(frozen=True, slots=True)
class Seen:
    """A request as its sender sees it.

    `sender` is an IPv4 address or an IPv6 /64 prefix, for limits, empty if there is none; `host` is
    the browser's host and port, unchecked, empty if it sends none.
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
        for name in _ABOUT_SENDERS:
            if sum(map(len, request.headers.getall(name, ()))) > _MOST_CHARS:
                raise NotForUsError(_TOO_LONG, 431)
        found = [
            self._forwarded(request, remote, direct),
            self._x_forwarded(request, remote, direct),
        ]
        claims = [one for one in found if one is not None]
        if any(one.sender != claims[0].sender for one in claims):
            raise NotForUsError(_TWO_SENDERS, 400)
        return claims[0] if claims else direct

    def direct(self, request: web.Request) -> Seen:
        """Return a request as if the other end of the connection had sent it itself."""
        host = ",".join(request.headers.getall("Host", ()))
        return Seen(limit_key(request.remote or ""), request.scheme, host)

    def sender(self, remote: str, x_forwarded_for: Sequence[str], forwarded: Sequence[str]) -> str:
        """Return a head's sender: as `seen` does if that is clear, otherwise the proxy."""
        address = parsed(remote)
        if address is None or not self._trusts(address):
            return limit_key(remote)
        # A longer header is refused later; its end names the sender well enough here.
        newest = [",".join(values)[-_MOST_CHARS:] for values in (x_forwarded_for, forwarded)]
        entries = _split(newest[:1]) or _FOR.findall(newest[1])
        return _limit_key(self._walk(address, entries)[0])

    def _x_forwarded(self, request: web.Request, remote: Address, direct: Seen) -> Seen | None:
        senders, schemes, hosts = (
            _values(request, f"X-Forwarded-{name}") for name in ("For", "Proto", "Host")
        )
        if not senders and not schemes and not hosts:
            return None
        sender, hops = self._walk(remote, senders)
        # Unlisted proxies add to it, too. A client that lies about the scheme of its own connection
        # deceives nobody but itself; no page can make a browser do so.
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
        """Return the last address that is not a proxy of ours, and how many of them passed it on.

        The entries to its left come from the sender, who may claim anything.
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


def limit_key(text: str) -> str:
    """Return an address as limits count it: an IPv4 address or an IPv6 /64 prefix."""
    address = parsed(text)
    return "" if address is None else _limit_key(address)


def is_same_site(request: web.Request) -> bool:
    """Whether the browser says that our own page asks, or says nothing (Fetch Metadata)."""
    sites = request.headers.getall("Sec-Fetch-Site", ())
    return all(site in ("same-origin", "none") for site in sites)


def is_same_origin(request: web.Request, origin: str) -> bool:
    """Whether a request comes from our own page, or from a program that is no browser.

    Browsers send a page's origin with everything that changes state (Fetch, 3.1; Fetch Metadata).
    A program could claim any origin, but it has nobody else's cookie.
    """
    origins = request.headers.getall("Origin", ())
    return is_same_site(request) and all(one.lower() == origin for one in origins)


def _believed(sender: Address, scheme: str, host: str, direct: Seen) -> Seen:
    seen_scheme = _SCHEMES.get(scheme.lower(), direct.scheme)
    return Seen(_limit_key(sender), seen_scheme, host or direct.host)


def _values(request: web.Request, name: str) -> list[str]:
    return _split(request.headers.getall(name, ()))


def _split(values: Sequence[str]) -> list[str]:
    joined = ",".join(values)
    return [value.strip() for value in joined.split(",")] if joined.strip() else []


def _outermost(values: Sequence[str], hops: int) -> str:
    """Return the outermost trusted proxy's value: proxies append theirs, or replace the list."""
    return values[-min(hops, len(values))] if values else ""


def _limit_key(address: Address) -> str:
    # One household or office has at least a /64 (RFC 6177).
    if address.version == 4:
        return str(address)
    return str(ipaddress.ip_network((address.packed[:8] + bytes(8), 64)))
