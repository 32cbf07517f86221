"""Hosts behind their routers inside ``async with Internet(…) as net``, and nothing afterwards."""

from __future__ import annotations

import asyncio
import os
import sys
from asyncio.subprocess import PIPE
from pathlib import Path
from typing import Final, Self

from e2e.link import leftovers, namespace
from e2e.link.link import End
from e2e.measure.errors import NotRunError
from e2e.reach.hosts import HELLO, HOSTS, Host

_ROOT: Final = Path(__file__).parents[2]
_START_WITHIN_S: Final = 15.0


class Internet:
    """Raises `NotRunError` on entering where no namespaces can be made."""

    def __init__(self, *hosts: Host) -> None:
        self._hosts = {host.name: host for host in hosts}
        self._held: list[int] = []
        self._ends: dict[str, End] = {}

    def __getitem__(self, name: str) -> End:
        """Return a host, or by its address a router, on which programs can be started."""
        return self._ends[name]

    async def forget(self, name: str) -> None:
        """Restart a host's router, which loses its mappings."""
        router = self._ends[self._hosts[name].public or name]
        for line in (
            "link set outside down",
            "link set outside up",
            "route add default dev outside",
        ):
            process = await router.spawn([namespace.tool("ip", "iproute2"), *line.split()])
            assert await process.wait() == 0

    async def __aenter__(self) -> Self:
        namespace.tool("nsenter", "util-linux")
        wiring = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "e2e.reach.wiring"), stdin=PIPE, stdout=PIPE, cwd=_ROOT
        )
        try:
            await self._take(wiring)
        except BaseException:
            await self.__aexit__()
            raise
        finally:
            await wiring.communicate(b"")  # closes its input
        return self

    async def __aexit__(self, *_: object) -> None:
        networks = {leftovers.namespace_of(held) for held in self._held[: len(self._ends)]}
        await asyncio.to_thread(leftovers.end_all, networks)
        await asyncio.gather(*(end.reap() for end in self._ends.values()))
        for held in self._held:
            os.close(held)
        self._held.clear()

    async def _take(self, wiring: asyncio.subprocess.Process) -> None:
        """Hold the namespaces ourselves: what wired them ends."""
        assert wiring.stdin is not None
        assert wiring.stdout is not None
        wiring.stdin.write(HOSTS.dump_json(list(self._hosts.values())) + b"\n")
        line = await asyncio.wait_for(wiring.stdout.readline(), _START_WITHIN_S)
        hello = HELLO.validate_json(line)
        if hello.networks is None:
            raise NotRunError(hello.refused)

        def hold(path: str) -> int:
            self._held.append(os.open(f"/proc/{wiring.pid}/{path}", os.O_RDONLY | os.O_CLOEXEC))
            return self._held[-1]

        held = {name: hold(f"fd/{network}") for name, network in hello.networks.items()}
        user = hold("ns/user") if hello.in_user_namespace else None
        for name, network in held.items():
            host = self._hosts.get(name)
            self._ends[name] = End(host.address if host else name, network, user)
