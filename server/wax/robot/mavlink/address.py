"""Parses the rover's address, in the syntax of pymavlink and the ground stations (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

Kind = Literal["serial", "udpin", "udpout", "tcp"]

_KINDS: Final[dict[str, Kind]] = {
    "udp": "udpin",  # as in pymavlink
    "udpin": "udpin",
    "udpout": "udpout",
    "tcp": "tcp",
}
_MAX_PORT: Final = 65_535


@dataclass(frozen=True, slots=True)
class Address:
    """`where` is a serial port's path, or a host with its `port`."""

    kind: Kind
    where: str
    port: int = 0


def parse(url: str) -> Address:
    """Parse the address; raises `ValueError` with a sentence."""
    scheme, colon, rest = url.partition(":")
    kind = _KINDS.get(scheme)
    if kind is None:
        if colon and "/" not in scheme:
            raise ValueError(
                f"{url} is no line to a rover; possible are a serial port such as /dev/ttyACM0,"
                " udpin:ADDRESS:PORT, udpout:ADDRESS:PORT and tcp:ADDRESS:PORT"
            )
        return Address("serial", url)
    host, _, port = rest.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) <= _MAX_PORT:
        raise ValueError(f"{url} has no address and port; write it as {scheme}:ADDRESS:PORT")
    return Address(kind, host.removeprefix("[").removesuffix("]"), int(port))


def check(url: str) -> str:
    """Return the address unchanged if it is valid; raises `ValueError`."""
    parse(url)
    return url
