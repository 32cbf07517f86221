"""An offer's text becomes one that aiortc can answer, or a sentence why not. Pure."""

from __future__ import annotations

import re
from typing import Final

from wax.errors import SignallingError

MAX_SDP_CHARS: Final = 32_768

_MAX_LINES: Final = 512
"""Browsers of today write 100 to 300, with every codec that they have."""
_MAX_CODECS: Final = 128
"""Of one section: a payload type has 7 bits (RFC 3550, 5.1)."""
_MAX_FEEDBACK_FOR_ALL: Final = 16
"""Lines of one section; aiortc copies each to every codec, so that few lines are much work."""
_MIN_MESSAGE_BYTES: Final = 65_536
"""What a page takes that says nothing (RFC 8841, 6.1), and the least that any browser tells; the
room with all its viewers is one message."""

_SECTIONS: Final = {"m=audio": "sound", "m=video": "picture", "m=application": "data channel"}
_NUMBER: Final = re.compile(r"[0-9]{1,10}")


def clean_offer(sdp: str) -> str:
    """Check an offer and leave out what would delay or block the answer.

    mDNS candidates cannot be resolved without multicast and cost a second each; the browser's
    checks reveal its address anyway (peer-reflexive, RFC 8445 7.3.1.3). `end-of-candidates` with
    nothing left would end the search before it began. Raises `SignallingError`.

    The work of aiortc's parser grows with codecs times lines; what no browser sends is refused
    before it begins.
    """
    if len(sdp) > MAX_SDP_CHARS:
        raise SignallingError(f"the offer is longer than {MAX_SDP_CHARS} characters")
    lines = [line for line in sdp.splitlines() if line]  # at the very places where aiortc does
    if not lines or not lines[0].startswith("v=0"):
        raise SignallingError("the offer is no session description: it does not begin with v=0")
    if len(lines) > _MAX_LINES:
        raise SignallingError(f"the offer has more than {_MAX_LINES} lines")
    for section, what in _SECTIONS.items():
        found = sum(line.startswith(section + " ") for line in lines)
        if found != 1:
            raise SignallingError(f"the offer must have one {what} section, it has {found}")
    _check_codecs(lines)
    _check_message_size(lines)
    return "\r\n".join(line for line in lines if not _is_unwanted(line)) + "\r\n"


def is_firefox(offer: str) -> bool:
    """Tell whether Firefox made an offer; its origin says so (RFC 8866 5.2)."""
    return "\no=mozilla" in offer


def _check_codecs(lines: list[str]) -> None:
    """Let each section have each payload type once."""
    types: set[int] = set()
    for_all = 0
    for line in lines:
        if line.startswith("m="):
            types.clear()
            for_all = 0
        elif line.startswith("a=rtpmap:"):
            payload_type = _number(line[len("a=rtpmap:") :].split(" ", 1)[0], "payload type")
            if payload_type in types:
                raise SignallingError(f"the offer has payload type {payload_type} twice")
            types.add(payload_type)
            if len(types) > _MAX_CODECS:
                raise SignallingError(f"a section of the offer has more than {_MAX_CODECS} codecs")
        elif line.startswith("a=rtcp-fb:*"):
            for_all += 1
            if for_all > _MAX_FEEDBACK_FOR_ALL:
                raise SignallingError(
                    f"a section of the offer has more than {_MAX_FEEDBACK_FOR_ALL} lines of"
                    " feedback for all codecs"
                )


def _check_message_size(lines: list[str]) -> None:
    for line in lines:
        if not line.startswith("a=max-message-size:"):
            continue
        size = _number(line[len("a=max-message-size:") :], "max-message-size")
        if 0 < size < _MIN_MESSAGE_BYTES:  # 0 is without limit
            raise SignallingError(
                f"the offer takes messages of {size} bytes only (max-message-size);"
                f" {_MIN_MESSAGE_BYTES} are needed"
            )


def _number(text: str, what: str) -> int:
    if _NUMBER.fullmatch(text) is None:
        raise SignallingError(f"the offer has a {what} that is no number")
    return int(text)


def _is_unwanted(line: str) -> bool:
    if line.startswith("a=end-of-candidates"):
        return True
    return line.startswith("a=candidate:") and ".local " in line
