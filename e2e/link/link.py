"""The link: two ends, and what lies between them."""

from __future__ import annotations

import asyncio
import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from tests.link.errors import LinkError
from tests.link.profile import Profile, load

from e2e.harness.child import ends
from e2e.link import leftovers, namespace
from e2e.link.statistics import HELLO, STATISTICS, Statistics
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import Mapping, Sequence

_ROOT: Final = Path(__file__).parents[2]
_ANSWER_WITHIN_S: Final = 15.0
_END_WITHIN_S: Final = 6.0
_ADDRESSES: Final = {"server": namespace.SERVER_ADDRESS, "browser": namespace.BROWSER_ADDRESS}


class End:
    """One end of the link: a network namespace with `lo` and one address towards the other end.

    No name server answers there, so a program that asks for a name waits for its timeout.
    """

    def __init__(self, address: str, network: int, user: int | None) -> None:
        self.address = address
        self._network = network
        self._user = user
        self._spawned: list[Process] = []
        self.names: Path | None = None
        """Replaces `/etc/hosts` here."""

    def command(self, arguments: Sequence[str]) -> list[str]:
        """Return the command line that runs another one at this end, as the same process.

        While the link exists, anyone may start it. It runs as the user who made the link; if that
        is not root, the program sees itself as root (Chromium then needs ``--no-sandbox``).
        """
        held = f"/proc/{os.getpid()}/fd"
        enter = [f"--net={held}/{self._network}"]
        if self._user is not None:
            enter = [f"--user={held}/{self._user}", "--preserve-credentials", *enter]
        mark = f"{leftovers.MARK}={leftovers.owner()}"
        if self.names is not None:
            bind = 'mount --bind "$0" /etc/hosts && exec "$@"'
            arguments = ["unshare", "--mount", "sh", "-c", bind, str(self.names), *arguments]
        return ["env", mark, namespace.tool("nsenter", "util-linux"), *enter, "--", *arguments]

    async def spawn(self, arguments: Sequence[str], **options: Any) -> Process:
        """Start a program at this end; `options` are those of `asyncio` for a subprocess.

        If it still runs when the link is left, it is ended with all its children.
        """
        process = await asyncio.create_subprocess_exec(
            *self.command(arguments), start_new_session=True, **options
        )
        self._spawned.append(process)
        return process

    async def spawn_python(self, arguments: Sequence[str], **options: Any) -> Process:
        """Start this Python at this end, in the folder from which our modules are imported."""
        return await self.spawn([sys.executable, *arguments], cwd=_ROOT, **options)

    def launcher(self, path: Path, program: str) -> Path:
        """Write a script that runs `program` at this end, for callers that need one executable."""
        path.write_text(f'#!/bin/sh\nexec {shlex.join(self.command([program]))} "$@"\n', "utf-8")
        path.chmod(0o755)
        return path

    async def reap(self) -> None:
        """Wait for the spawned processes, which have been ended."""
        await asyncio.gather(*(process.wait() for process in self._spawned))


class Held:
    """Namespaces that we hold too, so that they outlive the process `pid`, which made them.

    `line` is the first line that it printed; `ends` are by name, which is the address if
    `addresses` has none. Raises `NotRunError` if it could make no namespaces.
    """

    def __init__(self, pid: int, line: bytes, addresses: Mapping[str, str]) -> None:
        hello = HELLO.validate_json(line)
        if hello.refused:
            raise NotRunError(hello.refused)
        self.start_s = hello.start_s
        paths = [f"fd/{network}" for network in hello.networks.values()]
        paths += ["ns/user"] * hello.in_user_namespace
        flags = os.O_RDONLY | os.O_CLOEXEC
        self._held = [os.open(f"/proc/{pid}/{path}", flags) for path in paths]
        user = self._held[-1] if hello.in_user_namespace else None
        self.ends = {
            name: End(addresses.get(name, name), held, user)
            for name, held in zip(hello.networks, self._held, strict=False)
        }

    async def end(self) -> None:
        """End everything in them, and release them."""
        networks = {leftovers.namespace_of(held) for held in self._held[: len(self.ends)]}
        await asyncio.to_thread(leftovers.end_all, networks)
        await asyncio.gather(*(end.reap() for end in self.ends.values()))
        for held in self._held:
            os.close(held)


class Link:
    """``async with Link("lan") as link``: both ends exist inside, and nothing is left afterwards.

    `profile` is a name, the path of a TOML file, or a `Profile`. Entering raises `ProfileError` or
    `NotRunError`.
    """

    server: End
    browser: End
    start_s: float
    """Monotonic time of the link's start; stalls are counted from it."""

    def __init__(self, profile: Profile | str) -> None:
        self.profile = load(profile) if isinstance(profile, str) else profile
        self._forwarder: Process | None = None
        self._held: Held | None = None
        self._asking = asyncio.Lock()

    async def __aenter__(self) -> Self:
        for command, package in (("ip", "iproute2"), ("nsenter", "util-linux")):
            namespace.tool(command, package)
        await asyncio.to_thread(leftovers.end_stale)
        self._forwarder = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "e2e.link.forwarder"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            cwd=_ROOT,
            env={**os.environ, leftovers.MARK: leftovers.owner()},
            start_new_session=True,  # Ctrl-C is for us alone: we end it when we are ready
        )
        try:
            settings = self.profile.model_dump_json(exclude_unset=True)
            held = self._held = Held(self._forwarder.pid, await self._ask(settings), _ADDRESSES)
        except BaseException:
            await self.__aexit__()
            raise
        self.server, self.browser, self.start_s = *held.ends.values(), held.start_s
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._forwarder is None:
            return
        forwarder, self._forwarder = self._forwarder, None
        assert forwarder.stdin is not None
        forwarder.stdin.close()
        await ends(forwarder, _END_WITHIN_S)
        if self._held is not None:
            # If the forwarder was killed; otherwise nothing is found any more.
            await self._held.end()

    async def statistics(self) -> Statistics:
        """Return the counts so far; raises `LinkError` if the forwarder has ended."""
        return STATISTICS.validate_json(await self._ask("statistics"))

    async def start_changes(self) -> float:
        """Start the profile's changes and traces now; return the monotonic time.

        Until then the conditions stay as they begin. Raises `LinkError` if the forwarder has ended.
        """
        return float(await self._ask("start_changes"))

    async def _ask(self, line: str) -> bytes:
        forwarder = self._forwarder
        if forwarder is None or forwarder.stdin is None or forwarder.stdout is None:
            raise LinkError("the link is not open; enter it with `async with`")
        async with self._asking:
            try:
                forwarder.stdin.write(line.encode() + b"\n")
                await forwarder.stdin.drain()
                answer = await asyncio.wait_for(forwarder.stdout.readline(), _ANSWER_WITHIN_S)
            except (ConnectionError, TimeoutError) as error:
                raise LinkError("the link does not answer; make it anew") from error
        if not answer:
            raise LinkError("the link has ended; its last words are on standard error")
        return answer
