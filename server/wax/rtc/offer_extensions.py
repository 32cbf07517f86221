"""Adds header extensions and feedback that aiortc does not know to its offer. Pure.

RFC 8285, 5; RFC 4585, 4.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.rtc.rtp import TRANSPORT_SEQUENCE

if TYPE_CHECKING:
    from collections.abc import Sequence

_FIRST_ID: Final = 5
"""aiortc uses the lower ones."""


def with_extensions(offer: str, uris: Sequence[str]) -> str:
    """Offer these extensions for sound and picture, and feedback if they number packets for it."""
    extensions = [f"a=extmap:{number} {uri}" for number, uri in enumerate(uris, _FIRST_ID)]
    has_feedback = TRANSPORT_SEQUENCE in uris
    lines: list[str] = []
    is_media = False
    for line in offer.splitlines():
        lines.append(line)
        if line.startswith("m="):
            is_media = line.startswith(("m=audio", "m=video"))
        elif is_media and line.startswith("a=mid:"):
            lines += extensions
        elif has_feedback and is_media and line.startswith("a=rtpmap:") and " rtx/" not in line:
            lines.append(f"a=rtcp-fb:{line.partition(':')[2].split()[0]} transport-cc")
    return "\r\n".join(lines) + "\r\n"
