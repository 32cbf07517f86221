"""Turns aiortc's offer into a browser's, and parses the answer (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from wax.rtc import rtp
from wax.rtc.offer_extensions import with_extensions

Kind = Literal["audio", "video"]
KINDS: Final[tuple[Kind, ...]] = ("audio", "video")


@dataclass(frozen=True, slots=True)
class Agreed:
    """What an answer negotiates about the packets."""

    kinds: dict[int, Kind]
    """By payload type, retransmissions left out."""
    retransmissions: frozenset[int]
    """Payload types of RTX (RFC 4588)."""
    extension_id: int | None
    """ID of the transport-wide sequence number; None if the server takes no such feedback."""


def as_browser(offer: str) -> str:
    """Add Chromium's extensions and feedback to aiortc's offer."""
    return with_extensions(offer, (rtp.TRANSPORT_SEQUENCE, rtp.PLAYOUT_DELAY))


def agreed(answer: str) -> Agreed:
    """Parse an answer (RFC 8866, 6.6; RFC 8285, 8)."""
    kinds: dict[int, Kind] = {}
    retransmissions: set[int] = set()
    extension_id = None
    kind: Kind | None = None
    for line in answer.splitlines():
        name, _, value = line.partition(":")
        if line.startswith("m="):
            kind = _kind(line)
        elif name == "a=rtpmap" and kind is not None:
            number, _, codec = value.partition(" ")
            if codec.lower().startswith("rtx/"):
                retransmissions.add(int(number))
            else:
                kinds[int(number)] = kind
        elif name == "a=extmap" and value.endswith(f" {rtp.TRANSPORT_SEQUENCE}"):
            extension_id = int(value.split()[0].partition("/")[0])
    return Agreed(kinds, frozenset(retransmissions), extension_id)


def _kind(section: str) -> Kind | None:
    return next((kind for kind in KINDS if section.startswith(f"m={kind}")), None)
