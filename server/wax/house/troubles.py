"""What the host is to know of a broker that is connected, as sentences. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.house.probes import LIMIT_S
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


def troubles(
    asks: Iterable[str], closed: Sequence[str], refused: Mapping[str, object]
) -> list[Sentence]:
    """Return what is kept from this server, and what it may not say.

    `asks` are the topics of commands, `closed` those of which none arrives. `refused` is why what
    was said at a topic was not taken; a probe, too, which then proves nothing.
    """
    unproven = [topic for topic in closed if topic in refused]
    unheard = [topic for topic in closed if topic not in refused]
    unsaid = [topic for topic in refused if topic not in set(asks)]
    found = []
    if unheard:
        topics = ", ".join(unheard)
        found.append(Sentence("house.not_heard", {"topics": topics, "limit": LIMIT_S}))
    if unproven:
        found.append(Sentence("house.not_proven", {"topics": ", ".join(unproven)}))
    if unsaid:
        found.append(not_said(unsaid, refused[unsaid[0]]))
    return found


def not_said(topics: Iterable[str], why: object) -> Sentence:
    """Return that a broker takes nothing at these topics, in its words why."""
    return Sentence("house.not_said", {"topics": ", ".join(topics), "why": str(why)})
