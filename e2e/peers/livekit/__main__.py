"""Run LiveKit under a process that publishes and serves a page: `python -m e2e.peers.livekit`.

When all of it works, one line names the page's address; if it cannot work, or a part of it ends,
one line on standard error says why, and the status is 1. It runs until Ctrl-C or SIGTERM.
"""

from __future__ import annotations

import argparse
import asyncio
import signal
import sys
from contextlib import AsyncExitStack
from functools import partial
from ipaddress import IPv4Address
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError
from e2e.peers.livekit.installation import find_client, find_server
from e2e.peers.livekit.page import pages
from e2e.peers.livekit.publish import by_sdk, by_whip
from e2e.peers.livekit.server import LiveKit, Ports
from e2e.peers.livekit.tokens import Key, in_room
from e2e.peers.media import set_bitrate, sources
from e2e.peers.sizes import SIZES

if TYPE_CHECKING:
    from collections.abc import Coroutine, Sequence

    from e2e.peers.sizes import Size

_STOP_WITHIN_S: Final = 1.5


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m e2e.peers.livekit")
    parser.add_argument("--how", choices=("sdk", "whip"), default="sdk", help="who publishes")
    parser.add_argument("--size", choices=SIZES, default="640x480", help="of the picture")
    parser.add_argument("--host", type=IPv4Address, default=IPv4Address("127.0.0.1"))
    parser.add_argument("--port", type=int, default=8080, help="the page's")
    parser.add_argument("--ports", type=int, nargs=3, default=(), help="LiveKit's own")
    return parser.parse_args(arguments)


async def run(asked: argparse.Namespace) -> None:
    """Run everything until it is cancelled. Raises `MeasureError`."""
    program, script, is_sdk = find_server(), find_client(), asked.how == "sdk"
    size: Size = SIZES[asked.size]
    set_bitrate(size)
    publish = partial(by_sdk, size=size) if is_sdk else by_whip
    key, address = Key.make(), str(asked.host)
    ports = Ports(*asked.ports)
    livekit = LiveKit(program, address, ports, key, is_by_default=is_sdk)
    place = (address, asked.port, f"ws://{address}:{ports.signal}")
    async with AsyncExitStack() as running:
        sent = running.enter_context(sources(size))
        running.push_async_callback(livekit.kill)
        await livekit.start()
        served = pages(*place, key, script.read_bytes(), size=size, is_adaptive=is_sdk)
        published = await running.enter_async_context(served)
        token = in_room(key, "robot", publishes=True)

        def begun() -> None:
            published.set()
            print(f"http://{address}:{asked.port}/", flush=True)

        parts = (publish(livekit.url, token, *sent, begun), livekit.fails())
        works = [asyncio.ensure_future(part) for part in parts]
        running.push_async_callback(stop, works)
        await asyncio.gather(*works)


async def stop(works: Sequence[asyncio.Future[None]]) -> None:
    for work in works:
        work.cancel()
    await asyncio.wait(works, timeout=_STOP_WITHIN_S)


async def until_signalled(running: Coroutine[None, None, None]) -> None:
    task = asyncio.current_task()
    assert task is not None
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)
    await running


def main() -> int:
    asked = parse(None)
    try:
        asyncio.run(until_signalled(run(asked)))
    except asyncio.CancelledError:
        return 0
    except (AssertionError, MeasureError, OSError) as error:
        print(error, file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
