"""The problems at a connected broker, as sentences for the host. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.house.probes import LIMIT_S
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


def troubles(
    asks: Iterable[str], closed: Sequence[str], refused: Mapping[str, object]
) -> list[Sentence]:
    """Return which commands do not arrive, and which topics the broker refuses.

    `asks` are the command topics, `closed` those whose probes do not return. `refused` maps a topic
    to why the broker refused a message there; where it refused a probe, nothing is proven.
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
    """Return the sentence that a broker refuses these topics, with its reason."""
    return Sentence("house.not_said", {"topics": ", ".join(topics), "why": str(why)})
