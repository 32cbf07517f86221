"""Check an offer's SDP and adapt it for aiortc, or raise a sentence that says why not. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from wax.config.camera import MAX_CAMERAS
from wax.errors import SignallingError
from wax.protocol.http_bodies import MAX_SDP_CHARS
from wax.rtc.candidates import without_unwanted
from wax.rtc.essential_lines import OURS, essential, whole_number
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Collection

    from wax.streams.interface import Codecs

_MAX_LINES: Final = 512
"""Current browsers write 100 to 300, with all their codecs."""
_MORE_LINES: Final = 128
"""For each additional camera, for which the page offers only some codecs."""
_MIN_MESSAGE_BYTES: Final = 65_536
"""The default limit (RFC 8841, 6.1), and the least of any browser; a room with all its viewers is
one message."""

_SECTIONS: Final = {"m=audio": "sound", "m=video": "picture", "m=application": "data channel"}
MAX_PICTURES: Final = 1 + MAX_CAMERAS
"""The driving view, and the additional cameras that a server can have."""
_MAX_SECTIONS: Final = 2 + MAX_PICTURES


def clean_offer(sdp: str, sender: str | None = None, codecs: Collection[str] = OURS) -> str:
    """Check an offer and remove what would delay or block the answer, and what nobody reads.

    Unwanted candidates are removed (`candidates.without_unwanted`); `sender` is the address that
    the offer came from, `codecs` are those that the server has. Raises `SignallingError`.

    The work of aiortc's parser grows with codecs times lines, so it gets only the lines that matter
    (`essential_lines`), and no offer that no browser would send.
    """
    if len(sdp) > MAX_SDP_CHARS:
        raise SignallingError(f"the offer is longer than {MAX_SDP_CHARS} characters")
    lines = [line for line in sdp.splitlines() if line]  # split exactly where aiortc does
    if not lines or not lines[0].startswith("v=0"):
        raise SignallingError("the offer is not a session description: it does not begin with v=0")
    firsts = [line.partition(" ")[0] for line in lines if line.startswith("m=")]
    further = min(firsts.count("m=video"), MAX_PICTURES) - 1
    most = _MAX_LINES + _MORE_LINES * max(further, 0)
    if len(lines) > most:
        raise SignallingError(f"the offer has more than {most} lines")
    for section, what in _SECTIONS.items():
        found = firsts.count(section)
        if what == "picture" and 1 <= found <= MAX_PICTURES:
            continue
        if found != 1:
            raise SignallingError(f"the offer must have one {what} section, it has {found}")
    if len(firsts) > _MAX_SECTIONS:
        raise SignallingError(f"the offer has more than {_MAX_SECTIONS} sections")
    kept = essential(lines, codecs)
    _check_message_size(kept)
    return "\r\n".join(without_unwanted(kept, sender)) + "\r\n"


def pictures(offer: str) -> int:
    """Return how many pictures an offer has room for; the first is the driving view."""
    return offer.count("\nm=video ")


def lacking(offer: str, codecs: Codecs) -> Sentence | None:
    """Say which of the server's codecs a checked offer lacks; None if it has them.

    Only the driving view counts: an additional camera may have no room.
    """
    if not _has(_sections(offer, "video")[0], codecs.video):
        return Sentence("request.no_video_codec", {"codec": codecs.video.upper()})
    if not _has(_sections(offer, "audio")[0], codecs.audio):
        return Sentence("request.no_audio_codec", {"codec": codecs.audio.upper()})
    return None


def takes(offer: str, picture: int, codec: str) -> bool:
    """Whether this picture of a checked offer, 0 for the driving view, may use this codec."""
    return _has(_sections(offer, "video")[picture], codec)


def _sections(offer: str, kind: str) -> list[str]:
    return [one.partition("\nm=")[0] for one in offer.split(f"\nm={kind} ")[1:]]


def _has(section: str, codec: str) -> bool:
    return re.search(rf"^a=rtpmap:\d+ {codec}/", section, re.IGNORECASE | re.MULTILINE) is not None


def is_firefox(offer: str) -> bool:
    """Whether Firefox made the offer, by its origin line (RFC 8866 5.2)."""
    return "\no=mozilla" in offer


def _check_message_size(lines: list[str]) -> None:
    for line in lines:
        if not line.startswith("a=max-message-size:"):
            continue
        size = whole_number(line[len("a=max-message-size:") :], "max-message-size")
        if 0 < size < _MIN_MESSAGE_BYTES:  # 0 means no limit
            raise SignallingError(
                f"the offer limits messages to {size} bytes (max-message-size);"
                f" {_MIN_MESSAGE_BYTES} are needed"
            )
