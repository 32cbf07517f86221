"""The only place that touches private parts of aiortc and aioice, and why each is needed.

Pinned in pyproject.toml to the minor versions that this was read against; `check` fails with a
readable sentence when a new version has moved something.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import aioice.ice
from aiortc import RTCRtpSender

from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Callable

_FOR_EVER: Final = 10**9
_LAST_RTP_TIME: Final = "_RTCRtpSender__rtp_timestamp"
_UINT32: Final = 2**32


def check() -> None:
    """Raise `StartError` naming each private part that this version no longer has."""
    missing = [
        name
        for name, there in (
            ("aioice.ice.CONSENT_FAILURES", hasattr(aioice.ice, "CONSENT_FAILURES")),
            ("aioice.ice.get_host_addresses", hasattr(aioice.ice, "get_host_addresses")),
            ("RTCRtpSender._send_keyframe", hasattr(RTCRtpSender, "_send_keyframe")),
            ("RTCRtpSender._retransmit", hasattr(RTCRtpSender, "_retransmit")),
            (
                "RTCRtpSender.__rtp_timestamp",
                _LAST_RTP_TIME in RTCRtpSender.__init__.__code__.co_names,
            ),
            ("RTCRtpSender._stream_id", "_stream_id" in RTCRtpSender.__init__.__code__.co_names),
        )
        if not there
    ]
    if missing:
        raise StartError(
            "this version of aiortc or aioice is not the one WAX was built for "
            f"({', '.join(missing)} moved); install the versions of requirements.lock"
        )


def install() -> None:
    """Mend aioice for the whole process; call once, before the first peer. Safe to repeat."""
    check()
    # Consent (RFC 7675) waits 0.5 s for an answer and closes a working connection whose round
    # trips take longer, yet notices a vanished browser after half a minute. Liveness is our
    # own heartbeat (rtc/link.py); consent must only never give up.
    aioice.ice.CONSENT_FAILURES = _FOR_EVER
    aioice.ice.get_host_addresses = _host_addresses


def _host_addresses(use_ipv4: bool, use_ipv6: bool) -> list[str]:
    """Offer 127.0.0.1 where there is nothing else: a machine with only a loopback interface."""
    return _found_addresses(use_ipv4, use_ipv6) or (["127.0.0.1"] if use_ipv4 else [])


_found_addresses = aioice.ice.get_host_addresses


def on_keyframe_request(sender: RTCRtpSender, callback: Callable[[], None]) -> None:
    """Call back on PLI and FIR: aiortc forgets them for tracks that return packets."""
    sender._send_keyframe = callback  # type: ignore[method-assign]  # see above


def ask_before_repeating(sender: RTCRtpSender, allows: Callable[[int], bool]) -> None:
    """Ask before a lost packet is sent again, by its sequence number: aiortc always does it."""
    repeat = sender._retransmit

    async def repeat_if_allowed(sequence_number: int) -> None:
        if allows(sequence_number):
            await repeat(sequence_number)

    sender._retransmit = repeat_if_allowed  # type: ignore[method-assign]  # see above


def own_sync_group(sender: RTCRtpSender, name: str) -> None:
    """Put this sender's track into a media stream of its own (`a=msid`, RFC 8830).

    A browser delays the sound of a common stream for a late picture; here sound is the master
    and `sync/` is the only coupling.
    """
    sender._stream_id = name


def rtp_origin(sender: RTCRtpSender, pts: int) -> int:
    """Return the random RTP time at which this sender counts zero (RFC 3550, 5.1).

    `pts` is the media time, in RTP clock units, of the packet that was sent last.
    """
    last: int = getattr(sender, _LAST_RTP_TIME)
    return (last - pts) % _UINT32
