"""Who is on the small internet: hosts, each on the open net or behind a router."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from pydantic import TypeAdapter

Protocol = Literal["tcp", "udp"]


@dataclass(frozen=True, slots=True)
class Host:
    """One machine; with `public` it is behind a router with that address.

    `forwards` are ports that the router opens to it. `udp` false: the router lets no UDP through.
    `symmetric`: each connection gets a port of its own (RFC 4787: address- and port-dependent
    mapping), else the port inside is kept. With `carrier` the provider translates once more, to
    that address. Hosts with one `public` are a household, in a network of 256 addresses, behind
    the router that the first of them describes.
    """

    name: str
    address: str
    public: str | None = None
    forwards: tuple[tuple[Protocol, int], ...] = ()
    udp: bool = True
    symmetric: bool = False
    carrier: str | None = None


HOSTS: Final[TypeAdapter[list[Host]]] = TypeAdapter(list[Host])
