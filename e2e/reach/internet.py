"""Hosts behind their routers inside ``async with Internet(…) as net``, and nothing afterwards."""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE
from pathlib import Path
from typing import Final, Self

from e2e.link import namespace
from e2e.link.link import End, Held
from e2e.reach.hosts import HOSTS, Host

_ROOT: Final = Path(__file__).parents[2]
_START_WITHIN_S: Final = 15.0


class Internet:
    """Raises `NotRunError` on entering where no namespaces can be made."""

    def __init__(self, *hosts: Host) -> None:
        self._hosts = {host.name: host for host in hosts}
        self._held: Held

    def __getitem__(self, name: str) -> End:
        """Return a host, or by its address a router, on which programs can be started."""
        return self._held.ends[name]

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
            await wiring.communicate(b"")  # closes its input
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._held.end()
