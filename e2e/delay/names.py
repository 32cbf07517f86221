"""Systems and profiles as a person calls them, in the order in which tables have them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.link import Profile, load, names

if TYPE_CHECKING:
    from collections.abc import Iterable

    from e2e.delay.cell import SystemName

SYSTEMS: Final[dict[SystemName, str]] = {
    "thesis": "thesis policy",
    "audio-master": "observer",
    "operator": "operator",
    "video-first": "video-first",
    "stock": "stock aiortc",
    "livekit": "LiveKit",
    "livekit-whip": "LiveKit, one layer",
}
COLOURS: Final[dict[SystemName, str]] = {
    "thesis": "#D55E00",
    "audio-master": "#0072B2",
    "operator": "#56B4E9",
    "video-first": "#009E73",
    "stock": "#E69F00",
    "livekit": "#CC79A7",
    "livekit-whip": "#999999",
}
"""Okabe and Ito's, which the colour-blind can tell apart; the peers are dashed besides."""
PEERS: Final[tuple[SystemName, ...]] = ("stock", "livekit", "livekit-whip")
GIVEN: Final = (
    "All systems are given the same test card, 640×480 at 30 pictures a second, Opus, no STUN, and "
    "a Chromium or Firefox of the same build behind the same link.",
    "Stock aiortc: MediaRelay and one VP8 encoder for each viewer, begun at 1 Mbit/s, as in its "
    "examples.",
    "LiveKit: server 1.11.0 in its default configuration, fed by its Python SDK as its quick start "
    "has it (VP8 with simulcast, at most 1 Mbit/s for the largest layer), and a page of "
    "livekit-client with adaptive stream and dynacast on.",
    "LiveKit, one layer: the same server with a playout delay of 0 to 10 ms, its preset for "
    "teleoperation, fed by WHIP with one VP8 layer of 1 Mbit/s; adaptive stream off, since there "
    "is one layer to choose from.",
)
"""What each system was given, a sentence each."""
AGE: Final = (
    "The age of a picture begins when the system under test gets it, and ends when the browser "
    "hands it to its compositor. Left out, with every system alike, are a camera’s exposure and "
    "transfer before that, 20 to 60 ms with most of them, and the compositor and screen after it."
)

WIRED: Final = ("same-machine", "lan", "campus", "internet-5m")
NARROW: Final = ("wireless-2m", "wireless-1m", "modem-56k", "dual-modem", "isdn-64k")
TODAY: Final = ("lte-good", "lte-edge", "wifi-bad", "satellite")
CHANGING: Final = ("step-down", "outage")
CHAPTER5: Final = (*WIRED, *NARROW, *TODAY, *CHANGING)


@cache
def profile(name: str) -> Profile:
    return load(name)


def profiles() -> list[str]:
    """Give the shipped profiles: those of the thesis, then today's, then any other by name."""
    return in_order(names())


def shown(name: str) -> str:
    """Name a profile as a person does, who has recorded drives in a folder of their own."""
    return Path(name).stem


def in_order(found: Iterable[str]) -> list[str]:
    """Each once, in the order of `profiles`."""
    return sorted(set(found), key=place)


def place(name: str) -> tuple[int, str]:
    """Give what profiles are sorted by."""
    return CHAPTER5.index(name) if name in CHAPTER5 else len(CHAPTER5), name


def loses(name: str) -> bool:
    """Whether packets are lost on the way to the browser by chance, not in a full queue alone."""
    return any(conditions.loss.mean > 0 for _, conditions in profile(name).down.steps())


def changes_s(name: str) -> list[tuple[float, str]]:
    """When a profile changes and to what, in words."""
    found: dict[float, list[str]] = {}
    for way, settings in (("down", profile(name).down), ("up", profile(name).up)):
        for change in settings.changes:
            words = found.setdefault(change.at_s, [])
            if change.outage is not None:
                words.append("nothing passes" if change.outage else "the link is back")
            elif change.rate_bps is not None:
                words.append(f"{way} {change.rate_bps / 1000:g} kbit/s")
            else:
                words.append(f"{way} changes")
    return [(at_s, ", ".join(dict.fromkeys(words))) for at_s, words in sorted(found.items())]
