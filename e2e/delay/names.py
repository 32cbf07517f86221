"""The labels of systems and profiles, in the order of the tables."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final, Literal

from e2e.link import load

SystemName = Literal[
    "thesis", "audio-master", "operator", "video-first", "stock", "livekit", "livekit-whip"
]
"""``audio-master`` is the observer's default, ``operator`` the operator's, also on the page.
``livekit`` is published by its Python SDK as in its quick start, ``livekit-whip`` by WHIP with one
layer."""
SYSTEMS: Final[dict[SystemName, str]] = {
    "operator": "operator",
    "audio-master": "observer",
    "video-first": "video-first",
    "thesis": "thesis policy",
    "stock": "stock aiortc",
    "livekit": "LiveKit",
    "livekit-whip": "LiveKit, one layer",
}
PEERS: Final[tuple[SystemName, ...]] = ("stock", "livekit", "livekit-whip")
OURS: Final[tuple[SystemName, ...]] = ("operator", "audio-master", "video-first")
GIVEN: Final = (
    "All systems are given the same test card, 640×480 at 30 pictures a second, Opus, no STUN, and "
    "a browser of the same build behind the same link; at 1280×720 each is given 2.5 Mbit/s where "
    "it has 1 Mbit/s else.",
    "Thesis policy: the algorithm of 2004 on today’s transport, media units of 500 ms of sound.",
    "Stock aiortc: MediaRelay and one VP8 encoder for each viewer, begun at 1 Mbit/s, as in its "
    "examples.",
    "LiveKit: server 1.11.0 in its default configuration, fed by its Python SDK as its quick start "
    "has it (VP8 with simulcast, at most 1 Mbit/s for the largest layer), and a page of "
    "livekit-client with adaptive stream and dynacast on.",
    "LiveKit, one layer: the same server with a playout delay of 0 to 10 ms, its preset for "
    "teleoperation, fed by WHIP with one VP8 layer of 1 Mbit/s; adaptive stream off, since there "
    "is one layer to choose from.",
)
"""How each system was set up, a sentence each."""
AGE: Final = (
    "The age of a picture begins when the system under test gets it, and ends when the browser "
    "hands it to its compositor. Left out, with every system alike, are a camera’s exposure and "
    "transfer before that, 20 to 60 ms with most of them, and the compositor and screen after it."
)
SHARPNESS: Final = (
    "Sharpness: the structural similarity (SSIM) of the brightness that stands on the page to the "
    "test card’s moving texture, or to a film of a drive through the simulated flat, at the "
    "source’s size, the mean of 15 moments in the 3 s after the other figures. A picture is "
    "compared with the card that it is of (age does not count), but one that stands for longer "
    "than 200 ms with the card of that moment."
)
ARRIVAL: Final = (
    "Arrival of a picture: its age when its last packet has come, by the same browser, so that "
    "decoding, drawing and the wait for the display’s refresh are left out."
)

WIRED: Final = ("same-machine", "lan", "campus", "internet-5m")
NARROW: Final = ("wireless-2m", "wireless-1m", "modem-56k", "dual-modem", "isdn-64k")
_TODAY: Final = ("lte-good", "lte-edge", "wifi-bad", "cafe", "stalls", "satellite")
LINKS: Final = (*WIRED, *NARROW, *_TODAY, "step-down", "outage")
profile: Final = cache(load)


def shown(name: str) -> str:
    """Return a profile's label; recorded drives are in a folder of the user's own."""
    return Path(name).stem


def changes_s(name: str) -> list[float]:
    """When a profile changes, in seconds from the start of its changes."""
    ways = (profile(name).down, profile(name).up)
    return sorted({change.at_s for way in ways for change in way.changes})
