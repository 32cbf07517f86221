"""Session descriptions: those that pass our checks go through aiortc's parser, as in a peer."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from aiortc.sdp import SessionDescription
from tests.fuzz.target import Target

from wax.errors import SignallingError
from wax.rtc.signalling import clean_offer, is_firefox

_OFFERS: Final = Path(__file__).parents[2] / "rtc" / "offers"

_SMALL: Final = """v=0
o=- 1 2 IN IP4 127.0.0.1
s=-
t=0 0
a=group:BUNDLE 0 1 2
a=msid-semantic: WMS
m=audio 9 UDP/TLS/RTP/SAVPF 111 63
c=IN IP4 0.0.0.0
a=rtcp:9 IN IP4 0.0.0.0
a=candidate:1 1 udp 2113937151 192.0.2.7 54597 typ host generation 0
a=candidate:2 1 udp 1677729535 192.0.2.8 54598 typ srflx raddr 0.0.0.0 rport 0
a=ice-ufrag:abcd
a=ice-pwd:abcdefghijklmnopqrstuvwx
a=ice-options:trickle
a=fingerprint:sha-256 00:11:22:33:44:55:66:77:88:99:AA:BB:CC:DD:EE:FF:00:11:22:33:44:55:66:77:88:99:AA:BB:CC:DD:EE:FF
a=setup:actpass
a=mid:0
a=extmap:1 urn:ietf:params:rtp-hdrext:ssrc-audio-level
a=recvonly
a=rtcp-mux
a=rtpmap:111 opus/48000/2
a=rtcp-fb:111 transport-cc
a=fmtp:111 minptime=10;useinbandfec=1
a=rtpmap:63 red/48000/2
a=fmtp:63 111/111
m=video 9 UDP/TLS/RTP/SAVPF 96 97
c=IN IP4 0.0.0.0
a=mid:1
a=recvonly
a=rtcp-mux
a=rtcp-rsize
a=rtpmap:96 VP8/90000
a=rtcp-fb:* nack pli
a=rtpmap:97 rtx/90000
a=fmtp:97 apt=96
a=ssrc-group:FID 1 2
a=ssrc:1 cname:x
m=application 9 UDP/DTLS/SCTP webrtc-datachannel
c=IN IP4 0.0.0.0
a=mid:2
a=sctp-port:5000
a=max-message-size:262144
""".replace("\n", "\r\n").encode()  # noqa: E501  # a line is a line


def _hear(data: bytes) -> None:
    try:
        offer = clean_offer(data.decode("utf-8", errors="replace"))
    except SignallingError:
        return
    is_firefox(offer)
    try:
        SessionDescription.parse(offer)
    except Exception:
        # `Peer.answer` turns all that this parser raises into one error; here it must only end
        # soon.
        return


_BROWSERS: Final = tuple(
    path.read_bytes().replace(b"\n", b"\r\n") for path in sorted(_OFFERS.glob("*.sdp"))
)

SDP: Final = Target(
    name="sdp",
    what="session descriptions, as far as aiortc's parser",
    hear=_hear,
    seeds=(_SMALL,),
    long_seeds=_BROWSERS,
    words=(
        b"m=audio 9 UDP/TLS/RTP/SAVPF 0\r\n", b"m=video 9 x 0\r\n", b"a=rtpmap:", b"a=rtcp-fb:*",
        b"a=fmtp:", b"a=ssrc:", b"a=ssrc-group:", b"a=candidate:", b"a=extmap:", b"a=setup:active",
        b"a=max-message-size:", b"a=sctpmap:5000 x 1", b"\r\n", "\u2028".encode(), b"\r",
        b"a=fingerprint:", b"a=msid:", b"a=bundle-only", b"a=ice-lite", b"c=IN IP6 ::1",
    ),
    max_bytes=8192,
)  # fmt: skip
