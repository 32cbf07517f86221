"""The private corners of aiortc: each is still where it was."""

from __future__ import annotations

import aioice.ice
import pytest
from aiortc import RTCPeerConnection, RTCRtpSender

from wax.errors import StartError
from wax.rtc import private


def test_all_private_parts_are_there() -> None:
    """The installed versions have every private part that WAX uses."""
    private.check()


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (aioice.ice, "CONSENT_FAILURES"),
        (aioice.ice, "get_host_addresses"),
        (RTCRtpSender, "_send_keyframe"),
        (RTCRtpSender, "_retransmit"),
    ],
)
def test_a_part_that_moved_is_named(
    owner: object, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A version that has moved a part is refused at start with its name."""
    monkeypatch.delattr(owner, name)
    with pytest.raises(StartError, match=name):
        private.check()


def test_a_machine_with_only_loopback_offers_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is no other address 127.0.0.1 is offered, and only there."""
    monkeypatch.setattr(private, "_found_addresses", lambda _4, _6: [])
    assert private._host_addresses(True, False) == ["127.0.0.1"]
    monkeypatch.setattr(private, "_found_addresses", lambda _4, _6: ["192.0.2.7"])
    assert private._host_addresses(True, False) == ["192.0.2.7"]


def test_consent_never_gives_up() -> None:
    """A link whose round trips exceed half a second is not closed; our heartbeat watches."""
    private.install()
    assert aioice.ice.CONSENT_FAILURES > 1_000_000


async def test_each_track_has_a_stream_of_its_own() -> None:
    """The answer puts sound and picture into streams that a browser does not couple."""
    pc = RTCPeerConnection()
    for kind in ("audio", "video"):
        private.own_sync_group(pc.addTransceiver(kind, direction="sendonly").sender, f"wax-{kind}")
    sdp = (await pc.createOffer()).sdp
    streams = {line.split()[0] for line in sdp.splitlines() if line.startswith("a=msid:")}
    await pc.close()
    assert streams == {"a=msid:wax-audio", "a=msid:wax-video"}
