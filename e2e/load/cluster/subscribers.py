"""Watches in a room in a process of its own, as often as it is told to.

``python -m e2e.load.cluster.subscribers URL`` reads from standard input how many are to
watch, and says the number once they do; each gets the best picture and the sound by LiveKit's SDK.
"""

from __future__ import annotations

import asyncio
import os
import sys
from typing import Final

import jwt
from livekit import rtc

from e2e.load.cluster.engine import KEY, ROOMS

_NICENESS: Final = 10
"""What decodes here must not delay whoever publishes on this core."""
_FOREVER_S: Final = 2**31


async def watch(url: str) -> None:
    """Do so until standard input ends; raises `rtc.ConnectError`."""
    rooms: list[rtc.Room] = []
    while line := await asyncio.to_thread(sys.stdin.readline):
        wanted = int(line)
        while len(rooms) < wanted:
            rooms.append(await _entered(url, f"subscriber {len(rooms)}"))
        while len(rooms) > wanted:
            await rooms.pop().disconnect()
        print(wanted, flush=True)


async def _entered(url: str, name: str) -> rtc.Room:
    grants = {"room": ROOMS[0], "roomJoin": True, "canPublish": False, "hidden": True}
    claims = {"iss": KEY.name, "sub": name, "exp": _FOREVER_S, "video": grants}
    token = jwt.encode(claims, KEY.secret, algorithm="HS256")
    room = rtc.Room()
    await room.connect(url, token, rtc.RoomOptions(auto_subscribe=False))
    for robot in room.remote_participants.values():
        for track in robot.track_publications.values():
            if track.kind == rtc.TrackKind.KIND_AUDIO or "640x480" in robot.identity:
                track.set_subscribed(True)
    return room


if __name__ == "__main__":
    os.nice(_NICENESS)
    asyncio.run(watch(sys.argv[1]))
