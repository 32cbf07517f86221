"""Run LiveKit, a publisher and a page under one process: `python -m e2e.peers.livekit`.

When all of it works, one line of JSON (`messages.Ready`) says where the page is; when it cannot,
one line says why. It runs until Ctrl-C or SIGTERM, or until a part of it ends.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import sys
from contextlib import AsyncExitStack, suppress
from ipaddress import IPv4Address
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import (
    VERSION,
    check_sdk,
    client_version,
    find_client,
    find_server,
)
from e2e.peers.livekit.messages import PUBLISHER_LINE, Published, Ready, Refusal, say
from e2e.peers.livekit.page import Pages
from e2e.peers.livekit.server import LiveKit, Ports
from e2e.peers.livekit.tokens import Key

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import Sequence

_ROOT: Final = Path(__file__).parents[3]
_PUBLISH_WITHIN_S: Final = 30.0
_STOP_WITHIN_S: Final = 1.5
_PORTS: Final = Ports()


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.peers.livekit",
        description=__doc__.splitlines()[0] if __doc__ else None,
    )
    parser.add_argument("--how", choices=("sdk", "whip"), default="sdk", help="who publishes")
    parser.add_argument("--host", type=IPv4Address, default=IPv4Address("127.0.0.1"))
    parser.add_argument("--port", type=int, default=8080, help="the page's")
    parser.add_argument("--signal-port", type=int, default=_PORTS.signal)
    parser.add_argument("--media-tcp-port", type=int, default=_PORTS.media_tcp)
    parser.add_argument("--media-udp-port", type=int, default=_PORTS.media_udp)
    parser.add_argument(
        "--media",
        type=lambda path: Path(path).absolute(),
        help="publish a film, instead of the test card",
    )
    return parser.parse_args(arguments)


async def run(asked: argparse.Namespace) -> None:
    """Run everything until it is cancelled. Raises `LiveKitError`."""
    program, script = find_server(), find_client()
    is_sdk = asked.how == "sdk"
    if is_sdk:
        check_sdk()
    key = Key.make()
    address = str(asked.host)
    ports = Ports(asked.signal_port, asked.media_tcp_port, asked.media_udp_port)
    livekit = LiveKit(program, address, ports, key, is_by_default=is_sdk)
    pages = Pages(f"ws://{address}:{ports.signal}", key, script, is_adaptive=is_sdk)
    async with AsyncExitStack() as running:
        running.push_async_callback(livekit.stop)
        await livekit.start()
        running.push_async_callback(pages.stop)
        await pages.start(address, asked.port)
        publisher = await start_publisher(asked.how, livekit.url, key, asked.media)
        running.push_async_callback(stop_publisher, publisher)
        pages.published = await first_published(publisher)
        say(
            Ready(
                url=f"http://{address}:{asked.port}/",
                server_version=VERSION,
                client_version=client_version(),
            )
        )
        await any_ended(livekit, publisher, pages)


async def start_publisher(how: str, url: str, key: Key, media: Path | None) -> Process:
    arguments = ["--how", how, "--url", url, *(["--media", str(media)] if media else [])]
    return await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "e2e.peers.livekit.publisher", *arguments),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        cwd=_ROOT,
        env={**os.environ, "LIVEKIT_API_KEY": key.name, "LIVEKIT_API_SECRET": key.secret},
        start_new_session=True,
    )


async def first_published(publisher: Process) -> int:
    """Return when it publishes, 1. Raises `LiveKitError`."""
    assert publisher.stdout is not None
    try:
        line = await asyncio.wait_for(publisher.stdout.readline(), _PUBLISH_WITHIN_S)
    except TimeoutError:
        raise LiveKitError(
            f"nothing was published within {_PUBLISH_WITHIN_S:g} s; see the publisher's complaints"
        ) from None
    if not line:
        raise LiveKitError("the publisher ended at its start; its last words are above")
    said = PUBLISHER_LINE.validate_json(line)
    if isinstance(said, Refusal):
        raise LiveKitError(said.refused)
    return said.times


async def any_ended(livekit: LiveKit, publisher: Process, pages: Pages) -> None:
    """Raise `LiveKitError` as soon as LiveKit or the publisher ends."""
    waits = {
        asyncio.ensure_future(livekit.ended()): "LiveKit",
        asyncio.ensure_future(counted(publisher, pages)): "the publisher",
    }
    try:
        done, _ = await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for wait in waits:
            wait.cancel()
    first = next(iter(done))
    raise LiveKitError(f"{waits[first]} ended with status {first.result()}; its log says why")


async def counted(publisher: Process, pages: Pages) -> int:
    """Read on how often it publishes until it ends; return its status."""
    assert publisher.stdout is not None
    while line := await publisher.stdout.readline():
        said = PUBLISHER_LINE.validate_json(line)
        if isinstance(said, Published):
            pages.published = said.times
    return await publisher.wait()


async def stop_publisher(publisher: Process) -> None:
    for ask in (publisher.terminate, publisher.kill):
        with suppress(ProcessLookupError):
            ask()
        with suppress(TimeoutError):
            await asyncio.wait_for(publisher.wait(), _STOP_WITHIN_S)
            return


async def until_signalled(asked: argparse.Namespace) -> None:
    task = asyncio.current_task()
    assert task is not None
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, task.cancel)
    await run(asked)


def main(arguments: Sequence[str] | None = None) -> int:
    asked = parse(arguments)
    try:
        asyncio.run(until_signalled(asked))
    except asyncio.CancelledError:
        return 0
    except LiveKitError as error:
        say(Refusal(refused=str(error)))
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
