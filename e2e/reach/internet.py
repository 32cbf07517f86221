"""Hosts, each on the open net or behind a router, inside ``async with Internet(…) as net``."""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, Self

from pydantic import TypeAdapter

from e2e.link import namespace
from e2e.link.link import End, Held

Protocol = Literal["tcp", "udp"]


@dataclass(frozen=True, slots=True)
class Host:
    """One machine; with `public` it is behind a router with that address.

    `forwards` are ports that the router forwards to it. Without `udp` the router lets no UDP
    through. If `symmetric`, each connection gets a port of its own (RFC 4787: address- and
    port-dependent mapping); otherwise the inner port is kept. With `carrier` the provider
    translates once more, to that address.

    Hosts with the same `public` are a household, in a network of 256 addresses, behind the router
    that the first of them describes.

    `address` may be an IPv6 address, and `ipv6` is a second address: nobody translates it, but a
    router lets in only answers.
    """

    name: str
    address: str
    public: str | None = None
    forwards: tuple[tuple[Protocol, int], ...] = ()
    udp: bool = True
    symmetric: bool = False
    carrier: str | None = None
    ipv6: str | None = None


HOSTS: Final[TypeAdapter[list[Host]]] = TypeAdapter(list[Host])
_ROOT: Final = Path(__file__).parents[2]
_START_WITHIN_S: Final = 15.0


class Internet:
    """The hosts and routers; entering raises `NotRunError` if no namespaces can be made."""

    def __init__(self, *hosts: Host) -> None:
        self._hosts = {host.name: host for host in hosts}
        self._held: Held

    def __getitem__(self, name: str) -> End:
        """Return a host, or a router by its address, on which programs can be started."""
        return self._held.ends[name]

    def know(self, names: Path) -> None:
        """Give every host the names in this file, which has the format of `/etc/hosts`."""
        for host in self._hosts:
            self[host].names = names

    async def forget(self, name: str) -> None:
        """Restart a host's router, which loses its mappings."""
        router = self[self._hosts[name].public or name]
        up = "link set outside up"
        for line in ("link set outside down", up, "route add default dev outside"):
            process = await router.spawn([namespace.tool("ip", "iproute2"), *line.split()])
            assert await process.wait() == 0

    async def __aenter__(self) -> Self:
        namespace.tool("nsenter", "util-linux")
        wiring = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "e2e.reach.wiring"), stdin=PIPE, stdout=PIPE, cwd=_ROOT
        )
        assert wiring.stdin is not None
        assert wiring.stdout is not None
        try:
            wiring.stdin.write(HOSTS.dump_json(list(self._hosts.values())) + b"\n")
            line = await asyncio.wait_for(wiring.stdout.readline(), _START_WITHIN_S)
            addresses = {host.name: host.address for host in self._hosts.values()}
            self._held = Held(wiring.pid, line, addresses)
        finally:
            await wiring.communicate(b"")  # closes the process's input
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._held.end()
