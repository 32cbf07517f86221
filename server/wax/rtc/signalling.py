"""An offer's text becomes one that aiortc can answer, or a sentence why not. Pure."""

from __future__ import annotations

from typing import Final

from wax.errors import SignallingError

MAX_SDP_CHARS: Final = 32_768

_SECTIONS: Final = {"m=audio": "sound", "m=video": "picture", "m=application": "data channel"}


def clean_offer(sdp: str) -> str:
    """Check an offer and leave out what would delay or block the answer.

    mDNS candidates cannot be resolved without multicast and cost a second each; the browser's
    checks reveal its address anyway (peer-reflexive, RFC 8445 7.3.1.3). `end-of-candidates` with
    nothing left would end the search before it began. Raises `SignallingError`.
    """
    if len(sdp) > MAX_SDP_CHARS:
        raise SignallingError(f"the offer is longer than {MAX_SDP_CHARS} characters")
    lines = sdp.replace("\r\n", "\n").split("\n")
    if not lines[0].startswith("v=0"):
        raise SignallingError("the offer is no session description: it does not begin with v=0")
    for section, what in _SECTIONS.items():
        found = sum(line.startswith(section + " ") for line in lines)
        if found != 1:
            raise SignallingError(f"the offer must have one {what} section, it has {found}")
    kept = [line for line in lines if line and not _is_unwanted(line)]
    return "\r\n".join(kept) + "\r\n"


def is_firefox(offer: str) -> bool:
    """Tell whether Firefox made an offer; its origin says so (RFC 8866 5.2)."""
    return "\no=mozilla" in offer


def _is_unwanted(line: str) -> bool:
    if line.startswith("a=end-of-candidates"):
        return True
    return line.startswith("a=candidate:") and ".local " in line
