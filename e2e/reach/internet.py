"""Hosts behind their routers inside ``async with Internet(…) as net``, and nothing afterwards."""

from __future__ import annotations

import asyncio
import os
import sys
from asyncio.subprocess import PIPE
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

from pydantic import TypeAdapter

from e2e.link import leftovers, namespace
from e2e.link.errors import UnavailableError
from e2e.link.link import End
from e2e.reach.router import HOSTS, Hello, Host

if TYPE_CHECKING:
    from asyncio.subprocess import Process

_ROOT: Final = Path(__file__).parents[2]
_START_WITHIN_S: Final = 15.0
_END_WITHIN_S: Final = 6.0
_HELLO: Final = TypeAdapter(Hello)


class Internet:
    """Raises `UnavailableError` on entering where no namespaces can be made."""

    def __init__(self, *hosts: Host) -> None:
        self._hosts = hosts
        self._router: Process | None = None
        self._held: list[int] = []
        self._ends: dict[str, End] = {}

    def __getitem__(self, name: str) -> End:
        """Return a host, on which programs can be started."""
        return self._ends[name]

    def forget(self, name: str) -> None:
        """Make a host's router forget its mappings."""
        assert self._router is not None
        assert self._router.stdin is not None
        self._router.stdin.write(f"{name}\n".encode())

    async def __aenter__(self) -> Self:
        for command, package in (("ip", "iproute2"), ("nsenter", "util-linux")):
            namespace.tool(command, package)
        self._router = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "e2e.reach.router"),
            stdin=PIPE,
            stdout=PIPE,
            cwd=_ROOT,
            env={**os.environ, leftovers.MARK: leftovers.owner()},
            start_new_session=True,
        )
        try:
            await self._take(self._router)
        except BaseException:
            await self.__aexit__()
            raise
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._router is None:
            return
        router, self._router = self._router, None
        assert router.stdin is not None
        router.stdin.close()
        try:
            await asyncio.wait_for(router.wait(), _END_WITHIN_S)
        except TimeoutError:
            router.kill()
            await router.wait()
        networks = {leftovers.namespace_of(held) for held in self._held[: len(self._hosts)]}
        await asyncio.to_thread(leftovers.end_all, networks)
        await asyncio.gather(*(end.reap() for end in self._ends.values()))
        for held in self._held:
            os.close(held)
        self._held.clear()

    async def _take(self, router: Process) -> None:
        """Hold the namespaces ourselves too, so that they outlive a router that is killed."""
        assert router.stdin is not None
        assert router.stdout is not None
        router.stdin.write(HOSTS.dump_json(list(self._hosts)) + b"\n")
        line = await asyncio.wait_for(router.stdout.readline(), _START_WITHIN_S)
        hello = _HELLO.validate_json(line)
        if hello.refused is not None:
            raise UnavailableError(hello.refused)
        process = f"/proc/{router.pid}"
        paths = [f"{process}/fd/{network}" for network in hello.networks]
        if hello.in_user_namespace:
            paths.append(f"{process}/ns/user")
        for path in paths:
            self._held.append(os.open(path, os.O_RDONLY | os.O_CLOEXEC))
        user = self._held[-1] if hello.in_user_namespace else None
        for host, held in zip(self._hosts, self._held, strict=False):
            self._ends[host.name] = End(host.address, held, user)
