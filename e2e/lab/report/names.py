"""Systems and profiles as a person calls them, in the order in which the page has them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tests.link import profile as profiles
from tests.link.errors import LinkError

from e2e.lab.plan import CHANGING, NARROW, TODAY, WIRED

if TYPE_CHECKING:
    from collections.abc import Iterable

    from e2e.lab.cell import SystemName

SYSTEMS: Final[dict[SystemName, str]] = {
    "thesis": "thesis policy",
    "audio-master": "audio-master",
    "operator": "operator",
    "video-first": "video-first",
    "stock": "stock aiortc",
    "livekit": "LiveKit",
}
COLOURS: Final[dict[SystemName, str]] = {
    "thesis": "#D55E00",
    "audio-master": "#0072B2",
    "operator": "#56B4E9",
    "video-first": "#009E73",
    "stock": "#E69F00",
    "livekit": "#CC79A7",
}
"""Okabe and Ito's, which the colour-blind can tell apart; the peers are dashed besides."""

OF_THE_THESIS: Final = (*WIRED, *NARROW)
"""Those of 5.2 and 5.3, those of 5.4, and those of 3.5's predictions."""
_ORDER: Final = (*OF_THE_THESIS, *TODAY, *CHANGING)


def in_order(names: Iterable[str]) -> list[str]:
    """Each once: the thesis's profiles, then today's, then any other by name."""
    return sorted(set(names), key=lambda name: (_ORDER.index(name) if name in _ORDER else 99, name))


def about(name: str) -> str:
    """Give what a profile says of itself; empty where it is not at hand."""
    profile = _load(name)
    return "" if profile is None else profile.about


def loses(name: str) -> bool:
    """Whether packets are lost on the way to the browser by chance, not in a full queue alone."""
    profile = _load(name)
    if profile is None:
        return False
    return any(conditions.loss.mean > 0 for _, conditions in profile.down.steps())


def changes_s(name: str) -> list[tuple[float, str]]:
    """When a profile changes and to what, in words; empty where it does not or is not at hand."""
    profile = _load(name)
    if profile is None:
        return []
    found: dict[float, list[str]] = {}
    for way, settings in (("down", profile.down), ("up", profile.up)):
        for change in settings.changes:
            words = found.setdefault(change.at_s, [])
            if change.outage is not None:
                words.append("nothing passes" if change.outage else "the link is back")
            elif change.rate_bps is not None:
                words.append(f"{way} {change.rate_bps / 1000:g} kbit/s")
            else:
                words.append(f"{way} changes")
    return [(at_s, ", ".join(dict.fromkeys(words))) for at_s, words in sorted(found.items())]


def _load(name: str) -> profiles.Profile | None:
    try:
        return profiles.load(name)
    except LinkError:
        return None
