"""Publish the test card, or a film again and again, to LiveKit: by its SDK or by WHIP.

A connection that is lost is made anew; what went wrong goes to standard error.
"""

from __future__ import annotations

import asyncio
import sys
from typing import TYPE_CHECKING, Final

import aiohttp
from aiortc.contrib.media import MediaRelay

from e2e.peers.livekit.tokens import publisher_token
from e2e.peers.livekit.whip import PublishError, published
from e2e.peers.media import CameraTrack, MicrophoneTrack

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.peers.livekit.tokens import Key
    from wax.capture.source import AudioSource, VideoSource

RETRY_AFTER_S: Final = 1.0
IDENTITY: Final = "robot"


async def publish_by_whip(
    url: str,
    key: Key,
    camera: VideoSource,
    microphone: AudioSource,
    again: Callable[[], None],
) -> None:
    """Publish for ever, and say so `again` each time it begins. Raises `RefusedError`."""
    relay = MediaRelay()  # a track ends with the connection that it was given to; these two go on
    video, audio = CameraTrack(camera), MicrophoneTrack(microphone)
    endpoint = f"{url}/whip/v1"
    async with aiohttp.ClientSession() as http:
        while True:
            token = publisher_token(key, IDENTITY)
            tracks = (relay.subscribe(audio), relay.subscribe(video))
            try:
                async with published(http, endpoint, token, tracks) as publication:
                    again()
                    state = await publication.ended()
                complain(f"the connection to {endpoint} is {state}; publishing again")
            except PublishError as error:
                complain(f"{error}; trying again in {RETRY_AFTER_S:g} s")
                await asyncio.sleep(RETRY_AFTER_S)


async def publish_by_sdk(
    url: str,
    key: Key,
    camera: VideoSource,
    microphone: AudioSource,
    again: Callable[[], None],
) -> None:
    """Publish for ever, and say so `again` each time it begins. Raises `LiveKitError`."""
    from e2e.peers.livekit import sdk  # noqa: PLC0415  # who publishes by WHIP may lack it

    while True:
        async with sdk.published(url, publisher_token(key, IDENTITY), camera, microphone) as ended:
            again()
            complain(f"{await ended()}; publishing again")


def complain(sentence: str) -> None:
    print(f"publisher: {sentence}", file=sys.stderr, flush=True)
