"""The host names and addresses that a request may name.

A website can point a name of its own at this machine (DNS rebinding), and would then have our
page's origin. So a request is answered only if it names us (RFC 9110, 7.2 and 15.5.20).
"""

from __future__ import annotations

import ipaddress
import re
import socket
from typing import TYPE_CHECKING, Final

import ifaddr

from wax.config.host_spelling import spellings

if TYPE_CHECKING:
    from collections.abc import Iterable

_AUTHORITY: Final = re.compile(
    r"(?:\[(?P<v6>[0-9A-Fa-f:.]{2,45})\]|(?P<name>\w[\w.-]{0,252}))(?P<port>:[0-9]{1,5})?"
)

_LOCAL: Final = ("localhost", "127.0.0.1", "::1")


def host_of(authority: str) -> str:
    """Return the host of a `Host` header, in lower case; raises `ValueError` if it is malformed."""
    return host_and_port(authority)[0]


def host_and_port(authority: str) -> tuple[str, str]:
    """Return the host as `host_of` does, and the port with its colon, or ""."""
    found = _AUTHORITY.fullmatch(authority)
    if found is None:
        raise ValueError("not a host")
    port = found["port"] or ""
    if (literal := found["v6"]) is not None:
        return str(ipaddress.IPv6Address(literal)), port
    return found["name"].lower().removesuffix("."), port


def own_addresses() -> set[str]:
    """Return this machine's current addresses, without IPv6 zones."""
    found = set()
    for adapter in ifaddr.get_adapters():
        for ip in adapter.ips:
            text = ip.ip if isinstance(ip.ip, str) else ip.ip[0]
            found.add(str(ipaddress.ip_address(text.partition("%")[0])))
    return found


def own_names() -> set[str]:
    """Return this machine's names: the loopback's, its host name, and the multicast DNS one."""
    machine = socket.gethostname().lower()
    short = machine.partition(".")[0]
    return {*_LOCAL, machine, *((short, f"{short}.local") if short else ())} - {""}


class HostNames:
    """The names that this server goes by: `configured` ones, and the machine's own.

    An international name counts in its own letters, too: programs may send it so.
    """

    def __init__(self, configured: Iterable[str]) -> None:
        self._names = own_names().union(*map(spellings, configured))
        self._addresses = own_addresses()
        self._looked_s = float("-inf")

    def knows(self, host: str, now_s: float) -> bool:
        """Whether a host, as `host_of` returns it, is this server.

        A machine's addresses change: an unknown one makes it look them up again, once a second at
        most.
        """
        if host in self._names or host in self._addresses:
            return True
        if now_s - self._looked_s < 1.0 or not _is_address(host):
            return False
        self._looked_s = now_s
        self._addresses = own_addresses()
        return host in self._addresses


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
