"""Publish the test card, or a film again and again, to LiveKit: by its SDK or by WHIP.

The key comes in ``LIVEKIT_API_KEY`` and ``LIVEKIT_API_SECRET``, as LiveKit's own tools have it.
A connection that is lost is made anew; what went wrong goes to standard error.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from aiortc.contrib.media import MediaRelay

from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.messages import Published, Refusal, say
from e2e.peers.livekit.tokens import Key, publisher_token
from e2e.peers.livekit.whip import PublishError, published
from e2e.peers.media import CameraTrack, MicrophoneTrack, set_bitrate, sources
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Coroutine, Mapping, Sequence

    from wax.media.source import AudioSource, VideoSource

RETRY_AFTER_S: Final = 1.0
IDENTITY: Final = "robot"


def key_from(variables: Mapping[str, str]) -> Key:
    """Return the key. Raises `LiveKitError` when it is not given."""
    name, secret = variables.get("LIVEKIT_API_KEY"), variables.get("LIVEKIT_API_SECRET")
    if not name or not secret:
        raise LiveKitError("set LIVEKIT_API_KEY and LIVEKIT_API_SECRET to a key of the server")
    return Key(name, secret)


async def publish_by_whip(url: str, key: Key, camera: VideoSource, microphone: AudioSource) -> None:
    """Publish for ever. Raises `RefusedError`."""
    relay = MediaRelay()  # a track ends with the connection that it was given to; these two go on
    video, audio = CameraTrack(camera), MicrophoneTrack(microphone)
    endpoint = f"{url}/whip/v1"
    times = 0
    async with aiohttp.ClientSession() as http:
        while True:
            token = publisher_token(key, IDENTITY)
            tracks = (relay.subscribe(audio), relay.subscribe(video))
            try:
                async with published(http, endpoint, token, tracks) as publication:
                    times += 1
                    say(Published(times=times))
                    state = await publication.ended()
                complain(f"the connection to {endpoint} is {state}; publishing again")
            except PublishError as error:
                complain(f"{error}; trying again in {RETRY_AFTER_S:g} s")
                await asyncio.sleep(RETRY_AFTER_S)


def complain(sentence: str) -> None:
    print(f"publisher: {sentence}", file=sys.stderr, flush=True)


async def publish_by_sdk(url: str, key: Key, camera: VideoSource, microphone: AudioSource) -> None:
    """Publish for ever. Raises `LiveKitError` where it cannot begin to."""
    from e2e.peers.livekit import sdk  # noqa: PLC0415  # who publishes by WHIP may lack it

    times = 0
    while True:
        async with sdk.published(url, publisher_token(key, IDENTITY), camera, microphone) as ended:
            times += 1
            say(Published(times=times))
            complain(f"{await ended()}; publishing again")


async def until_signalled(publishing: Coroutine[Any, Any, None]) -> None:
    task = asyncio.current_task()
    assert task is not None
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, task.cancel)
    await publishing


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--how", choices=("sdk", "whip"), default="whip")
    parser.add_argument("--url", required=True, help="LiveKit's, as http://127.0.0.1:7880")
    parser.add_argument("--media", type=Path, help="a film, instead of the test card")
    asked = parser.parse_args(arguments)
    set_bitrate()
    try:
        key = key_from(os.environ)
        with sources(asked.media) as (camera, microphone):
            publish = publish_by_sdk if asked.how == "sdk" else publish_by_whip
            asyncio.run(until_signalled(publish(asked.url, key, camera, microphone)))
    except asyncio.CancelledError:
        return 0
    except (LiveKitError, SourceError) as error:
        say(Refusal(refused=str(error)))
        complain(str(error))
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
