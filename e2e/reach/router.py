"""The process that is the internet: holds a namespace for each host and moves packets among them.

``python -m e2e.reach.router`` reads the hosts as one line of JSON, answers with one line (the
descriptors of their namespaces, or a refusal), and then obeys each line, which is the name of a
host whose router is to forget. When its standard input ends it ends everything in the namespaces.
"""

from __future__ import annotations

import json
import os
import select
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import TypeAdapter

from e2e.link import leftovers, namespace
from e2e.link.errors import UnavailableError
from e2e.link.tun import open_tun, read_packets
from e2e.reach.nat import Nat
from e2e.reach.packet import UDP, read

if TYPE_CHECKING:
    from collections.abc import Sequence

_BATCH = 32


@dataclass(frozen=True, slots=True)
class Host:
    """One machine; with `public` it is behind a router with that address.

    `forwards` are protocols (17 is UDP) and ports. `udp` false: a firewall lets no UDP through.
    Hosts with one `public` are a household: they reach each other, the world only the first.
    """

    name: str
    address: str
    public: str | None = None
    forwards: tuple[tuple[int, int], ...] = ()
    udp: bool = True


HOSTS: TypeAdapter[list[Host]] = TypeAdapter(list[Host])


@dataclass(frozen=True, slots=True)
class Hello:
    """The first line: descriptors of the hosts' namespaces, or why there are none."""

    networks: tuple[int, ...] = ()
    in_user_namespace: bool = False
    refused: str | None = None


class _Place:
    """A host, its device and its router."""

    def __init__(self, host: Host, device: int) -> None:
        self.host = host
        self.device = device
        self.nat = host.public and Nat(host.public, host.address, host.forwards)

    @property
    def seen_as(self) -> str:
        return self.host.public or self.host.address

    def outward(self, packet: bytes) -> bytes | None:
        """Return what comes out into the world."""
        return self.nat.outward(packet) if self.nat else packet

    def inward(self, packet: bytes) -> bytes | None:
        """Return what comes in to the host."""
        return self.nat.inward(packet) if self.nat else packet

    def stops(self, packet: bytes) -> bool:
        """Whether the firewall does."""
        flow = read(packet)
        return flow is None or (flow.protocol == UDP and not self.host.udp)


class Router:
    """Moves until its input ends."""

    def __init__(self, places: Sequence[_Place]) -> None:
        self._places = {place.seen_as: place for place in reversed(places)}
        self._at_home = {(place.host.public, place.host.address): place for place in places}
        self._by_device = {place.device: place for place in places}

    def run(self, control: int) -> None:
        while True:
            readable, _, _ = select.select([control, *self._by_device], [], [])
            for source in readable:
                if source != control:
                    self._take(self._by_device[source])
                elif not self._obey(control):
                    return

    def _take(self, place: _Place) -> None:
        for packet in read_packets(place.device, _BATCH):
            if place.stops(packet):
                continue
            if (neighbour := self._neighbour(place, packet)) is not None:
                os.write(neighbour.device, packet)
            elif (out := place.outward(packet)) is not None:
                self._deliver(out)

    def _neighbour(self, place: _Place, packet: bytes) -> _Place | None:
        """Return the host in the same household to which a packet goes, if it does."""
        flow = read(packet)
        if flow is None or place.host.public is None:
            return None
        return self._at_home.get((place.host.public, flow.target.host))

    def _deliver(self, packet: bytes) -> None:
        flow = read(packet)
        to = None if flow is None else self._places.get(flow.target.host)
        if to is None or to.stops(packet):
            return
        into = to.inward(packet)
        if into is not None:
            os.write(to.device, into)

    def _obey(self, control: int) -> bool:
        names = os.read(control, 4096).decode().split()
        for place in self._by_device.values():
            if place.host.name in names and place.nat:
                place.nat.forget()
        return bool(names)


def main() -> int:
    control = sys.stdin.fileno()
    # Unbuffered, because the lines after the first are read when `select` tells of them.
    with open(control, "rb", buffering=0, closefd=False) as lines:
        hosts = HOSTS.validate_json(lines.readline())
    user = Path("/proc/self/ns/user").readlink()
    places, networks = [], []
    try:
        for host in hosts:
            networks.append(namespace.enter_new_network())
            places.append(_Place(host, open_tun(namespace.DEVICE)))
            namespace.configure(namespace.DEVICE, f"{host.address}/24")
    except UnavailableError as error:
        _answer(Hello(refused=str(error)))
        return 1
    try:
        is_inside = Path("/proc/self/ns/user").readlink() != user
        _answer(Hello(networks=tuple(networks), in_user_namespace=is_inside))
        Router(places).run(control)
    finally:
        leftovers.end_all({leftovers.namespace_of(one) for one in networks}, but=os.getpid())
    return 0


def _answer(hello: Hello) -> None:
    print(json.dumps(asdict(hello)), flush=True)


if __name__ == "__main__":
    sys.exit(main())
