"""``python -m e2e.lab.crowd URL HOW NUMBER SLOW``: hold a crowd until the input ends.

HOW is ``wax`` or ``stock``; the first SLOW of them are behind a modem each. Says a line of JSON
when all see and hear, another for each line that it is given.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from typing import Final

import aiohttp

from e2e.bench.viewer import Offering
from e2e.lab.crowd.near import Count
from e2e.lab.crowd.onlooker import Onlooker, offer_as_chromium
from e2e.measure.errors import MeasureError

JOINING_AT_ONCE: Final = 4
_TURN_S: Final = 0.01
"""How often it is looked whether somebody has something to say: that is how late it may be."""


async def _be_crowd(offering: Offering, number: int, slow: int) -> None:
    viewers = [Onlooker(offering, line=one if one < slow else None) for one in range(number)]
    telling = asyncio.create_task(_tell(viewers), name="feedback")
    try:
        async with aiohttp.ClientSession() as http:
            for start in range(0, number, JOINING_AT_ONCE):
                some = viewers[start : start + JOINING_AT_ONCE]
                await asyncio.gather(*(viewer.connect(http) for viewer in some))
        _say(_count(viewers, slow))
        while await asyncio.to_thread(sys.stdin.readline):
            if telling.done():
                telling.result()
            _say(_count(viewers, slow))
    except (MeasureError, aiohttp.ClientError) as error:
        _say(Count(at_s=0.0, frames=[], packets=0, lost=0, problem=str(error)))
    finally:
        telling.cancel()
        await asyncio.gather(*(viewer.close() for viewer in viewers))


async def _tell(viewers: list[Onlooker]) -> None:
    while True:
        for viewer in viewers:
            await viewer.tell(time.monotonic())
        await asyncio.sleep(_TURN_S)


def _count(viewers: list[Onlooker], slow: int) -> Count:
    counts = [viewer.counts() for viewer in viewers]
    streams = [stream for count in counts for stream in (count.video, count.audio)]
    return Count(
        at_s=time.monotonic(),
        frames=[count.video.frames for count in counts],
        packets=sum(stream.packets for stream in streams),
        lost=sum(stream.lost for stream in streams),
        slow=slow,
        feedbacks=sum(viewer.feedbacks for viewer in viewers),
        repeats_asked=sum(viewer.repeats_asked for viewer in viewers),
        keyframes_asked=sum(viewer.keyframes_asked for viewer in viewers),
    )


def _say(count: Count) -> None:
    print(json.dumps(count.model_dump()), flush=True)


def main() -> None:
    url, how, number, slow = sys.argv[1:]
    wax = how == "wax"
    offering = Offering(url=url + ("/api/offer" if wax else "/offer"), wax=wax)
    offer_as_chromium()
    asyncio.run(_be_crowd(offering, int(number), int(slow)))


if __name__ == "__main__":
    main()
