"""Run LiveKit under a process that publishes and serves a page: `python -m e2e.peers.livekit`.

When all of it works, one line of JSON (`messages.Ready`) says where the page is; when it cannot,
one line says why. It runs until Ctrl-C or SIGTERM, or until a part of it ends.
"""

from __future__ import annotations

import argparse
import asyncio
import signal
import sys
import time
from contextlib import AsyncExitStack
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
from e2e.peers.livekit.messages import Ready, Refusal, say
from e2e.peers.livekit.page import Pages
from e2e.peers.livekit.publisher import publish_by_sdk, publish_by_whip
from e2e.peers.livekit.server import LiveKit, Ports
from e2e.peers.livekit.tokens import Key
from e2e.peers.media import set_bitrate, sources
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Sequence

_PUBLISH_WITHIN_S: Final = 30.0
_STOP_WITHIN_S: Final = 1.5
_LOOK_EVERY_S: Final = 0.05
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
    """Run everything until it is cancelled. Raises `LiveKitError` or `SourceError`."""
    program, script = find_server(), find_client()
    is_sdk = asked.how == "sdk"
    if is_sdk:
        check_sdk()
    key = Key.make()
    address = str(asked.host)
    ports = Ports(asked.signal_port, asked.media_tcp_port, asked.media_udp_port)
    livekit = LiveKit(program, address, ports, key, is_by_default=is_sdk)
    pages = Pages(f"ws://{address}:{ports.signal}", key, script, is_adaptive=is_sdk)
    publish = publish_by_sdk if is_sdk else publish_by_whip
    async with AsyncExitStack() as running:
        camera, microphone = running.enter_context(sources(asked.media))
        running.push_async_callback(livekit.stop)
        await livekit.start()
        running.push_async_callback(pages.stop)
        await pages.start(address, asked.port)
        publishing = asyncio.create_task(
            publish(livekit.url, key, camera, microphone, pages.published_again)
        )
        running.push_async_callback(stop, publishing)
        await begun(publishing, pages)
        say(
            Ready(
                url=f"http://{address}:{asked.port}/",
                server_version=VERSION,
                client_version=client_version(),
            )
        )
        await any_ended(livekit, publishing)


async def begun(publishing: asyncio.Task[None], pages: Pages) -> None:
    """Return once it publishes. Raises `LiveKitError`, or whatever ended it."""
    until_s = time.monotonic() + _PUBLISH_WITHIN_S
    while not pages.published:
        if publishing.done():
            publishing.result()
        if time.monotonic() > until_s:
            raise LiveKitError(
                f"nothing was published within {_PUBLISH_WITHIN_S:g} s; see its complaints"
            )
        await asyncio.sleep(_LOOK_EVERY_S)


async def any_ended(livekit: LiveKit, publishing: asyncio.Task[None]) -> None:
    """Raise `LiveKitError` as soon as LiveKit ends, or what ends the publishing."""
    ended = asyncio.ensure_future(livekit.ended())
    try:
        await asyncio.wait({ended, publishing}, return_when=asyncio.FIRST_COMPLETED)
        if publishing.done():
            publishing.result()
    finally:
        ended.cancel()
    raise LiveKitError(f"LiveKit ended with status {ended.result()}; its log says why")


async def stop(publishing: asyncio.Task[None]) -> None:
    publishing.cancel()
    await asyncio.wait({publishing}, timeout=_STOP_WITHIN_S)


async def until_signalled(asked: argparse.Namespace) -> None:
    task = asyncio.current_task()
    assert task is not None
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, task.cancel)
    await run(asked)


def main(arguments: Sequence[str] | None = None) -> int:
    asked = parse(arguments)
    set_bitrate()
    try:
        asyncio.run(until_signalled(asked))
    except asyncio.CancelledError:
        return 0
    except (LiveKitError, SourceError) as error:
        say(Refusal(refused=str(error)))
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
