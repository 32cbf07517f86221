"""Lines of an offer that delay the answer are removed; an unusable offer gets a sentence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from aiortc.codecs import CODECS, HEADER_EXTENSIONS
from aiortc.rtcpeerconnection import find_common_codecs
from aiortc.rtcrtpparameters import RTCRtcpFeedback
from aiortc.sdp import SessionDescription
from hypothesis import given
from hypothesis import strategies as st
from tests.rtc.steps import counted

from wax.errors import SignallingError
from wax.protocol.http_bodies import MAX_SDP_CHARS
from wax.rtc.rtp import PLAYOUT_DELAY, TRANSPORT_SEQUENCE
from wax.rtc.signalling import clean_offer, is_firefox, lacking, pictures, takes
from wax.sentence import Sentence
from wax.streams.interface import Codecs

if TYPE_CHECKING:
    from collections.abc import Callable

TWCC = RTCRtcpFeedback(type="transport-cc")
EXTENSIONS = [
    *{one.uri: None for of_kind in HEADER_EXTENSIONS.values() for one in of_kind},
    TRANSPORT_SEQUENCE,
    PLAYOUT_DELAY,
]
GOOD = "\r\n".join(
    [
        "v=0",
        "o=- 1 2 IN IP4 127.0.0.1",
        "m=audio 9 UDP/TLS/RTP/SAVPF 111",
        "a=candidate:1 1 udp 2113937151 1f4712db-ea17-4bcf-a596-105139dfd8bf.local 54596 typ host",
        "a=candidate:2 1 udp 2113937151 192.0.2.7 54597 typ host",
        "a=end-of-candidates",
        "m=video 9 UDP/TLS/RTP/SAVPF 96",
        "m=application 9 UDP/DTLS/SCTP webrtc-datachannel",
        "",
    ]
)


def test_candidates_with_unresolvable_names_are_removed() -> None:
    """Candidates with mDNS names and the end of candidates are removed, all else stays in order."""
    kept = clean_offer(GOOD).split("\r\n")
    dropped = [line for line in GOOD.split("\r\n") if line not in kept]
    assert [line.split(" ")[0] for line in dropped] == ["a=candidate:1", "a=end-of-candidates"]
    assert kept == [line for line in GOOD.split("\r\n") if line not in dropped]


@pytest.mark.parametrize(
    ("sdp", "says"),
    [
        ("", "does not begin with v=0"),
        ("hello", "does not begin with v=0"),
        ("v=0\r\n" + "a" * MAX_SDP_CHARS, "longer than"),
        ("v=0\n" + "a=x\n" * 512, "more than 512 lines"),
        (GOOD.replace("m=video", "m=vide0"), "one picture section, it has 0"),
        (GOOD + "m=video 9 x 0\r\n" * 5, "one picture section, it has 6"),
        (GOOD + "m=video 9 x 0\r\n" + "a=x\r\n" * 640, "more than 640 lines"),
        (GOOD + "m=audio 9 UDP/TLS/RTP/SAVPF 0\r\n", "one sound section, it has 2"),
    ],
)
def test_an_unusable_offer_gets_a_sentence(sdp: str, says: str) -> None:
    """A bad offer is refused with the reason."""
    with pytest.raises(SignallingError, match=says):
        clean_offer(sdp)


BROWSERS = {
    path.stem: path.read_text(encoding="utf-8").replace("\n", "\r\n")
    for path in sorted((Path(__file__).parent / "offers").glob("*.sdp"))
}
"""Browsers' offers to this page, with all their codecs; Safari's was made from its list."""


def _negotiated(offer: str, codecs: Codecs) -> list[object]:
    """Return everything on which aiortc's answer and ours depend."""
    read = SessionDescription.parse(offer)
    found: list[object] = [read.group, read.msid_semantic]
    for media in read.media:
        sent = f"{media.kind}/{codecs.audio if media.kind == 'audio' else codecs.video}"
        known = find_common_codecs(CODECS.get(media.kind, []), media.rtp.codecs)
        ours = [one for one in known if one.mimeType.lower() == sent]
        numbers = [one.payloadType for one in ours]
        repairs = [one for one in known if one.parameters.get("apt") in numbers]
        red = {"/".join([str(numbers[0])] * 2): None} if numbers else {}
        offered = media.rtp.codecs
        found += [
            (media.kind, media.rtp.muxId, media.msid, media.direction, media.dtls, media.ice),
            (media.port, media.profile, media.rtcp_mux, media.sctp_port, media.sctpCapabilities),
            (ours, repairs, [one for one in offered if numbers and one.parameters == red]),
            [TWCC in one.rtcpFeedback for one in offered if one.payloadType in numbers],
            [one for one in media.rtp.headerExtensions if one.uri in EXTENSIONS],
            read.webrtc_track_id(media),
        ]
    return found


@pytest.mark.parametrize("codecs", [Codecs("opus", "vp8"), Codecs("pcmu", "h264")])
@pytest.mark.parametrize("browser", ["chromium", "firefox", "safari"])
def test_removed_lines_change_no_answer(browser: str, codecs: Codecs) -> None:
    """Removing lines about formats that nobody here has changes no answer."""
    offer = BROWSERS[browser]
    cleaned = clean_offer(offer, "fd00::2", codecs.names)
    assert is_firefox(cleaned) == (browser == "firefox")
    assert cleaned.count("\n") < 80
    assert _negotiated(cleaned, codecs) == _negotiated(offer, codecs)


def test_a_picture_that_no_camera_can_fill_keeps_a_codec() -> None:
    """A picture without a camera keeps a codec: aiortc answers no offer without one."""
    other = "m=video 9 x 98 99\r\na=rtpmap:98 VP9/90000\r\na=rtpmap:99 VP8/90000\r\n"
    cleaned = clean_offer(BROWSERS["chromium"] + other, None, {"opus", "h264"})
    assert cleaned.endswith("m=video 9 x 99\r\na=rtpmap:99 VP8/90000\r\n")


@pytest.mark.parametrize("browser", ["chromium", "firefox", "safari"])
def test_a_codec_that_is_not_offered_is_named(browser: str) -> None:
    """Sound and driving view each need the server's codec, in their own section."""
    offer = clean_offer(BROWSERS[browser])
    ours = Codecs(audio="opus", video="vp8")
    assert lacking(offer, ours) is None
    assert lacking(offer, Codecs(audio="pcmu", video="h264")) is None
    h264_alone = offer.replace(" VP8/", " x/")
    assert lacking(h264_alone, ours) == Sentence("request.no_video_codec", {"codec": "VP8"})
    assert lacking(h264_alone, Codecs(audio="opus", video="h264")) is None
    no_opus = offer.replace(" opus/", " x/")
    assert lacking(no_opus, ours) == Sentence("request.no_audio_codec", {"codec": "OPUS"})
    assert takes(offer + "m=video 9 x 96\r\na=rtpmap:96 VP8/90000\r\n", 1, "vp8")
    assert not takes(offer + "m=video 9 x 96\r\na=rtpmap:96 VP8/90000\r\n", 1, "h264")


@pytest.mark.parametrize("browser", ["chromium", "firefox", "safari"])
def test_browsers_have_room_to_grow(browser: str) -> None:
    """Browsers may add half as many codecs and lines again, and 100 candidates."""
    new = "".join(f"a=rtpmap:{n} x/90000\r\na=rtcp-fb:{n} nack\r\n" for n in range(200, 225))
    new += "".join(f"a=candidate:{n} 1 udp 1 192.0.2.7 {n} typ host\r\n" for n in range(100))
    clean_offer(BROWSERS[browser].replace("m=application", new + "m=application"))


def _with(video: str) -> str:
    return GOOD.replace("m=application", video + "m=application")


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("a=rtpmap:96 x/90000\r\n" * 200, "payload type 96 twice"),
        ("a=rtpmap:96 x/90000\r\na=rtpmap:096 x/90000\r\n", "payload type 96 twice"),
        ("a=rtpmap:٩٦ x/90000\r\n", "payload type that is not a number"),
        ("a=rtpmap: 96 x/90000\r\n", "payload type that is not a number"),
        ("".join(f"a=rtpmap:{n} x/90000\r\n" for n in range(129)), "more than 128 codecs"),
        ("a=fingerprint:sha-256 AA\r\n" * 5, "more than 4 fingerprints"),
        ("a=mid:" + "v" * 512 + "\r\n", "more than 512 characters"),
        ("m=text 9 x 0\r\n" * 5, "more than 7 sections"),
        ("a=x\u2028" * 600, "more than 512 lines"),
    ],
)
def test_lines_that_multiply_the_parsers_work_are_refused(more: str, says: str) -> None:
    """Repeated codecs, and feedback for every codec, do not reach aiortc."""
    with pytest.raises(SignallingError, match=says):
        clean_offer(_with(more))


MANY: dict[str, Callable[[int], str]] = {
    "formats": "a=fmtp:96 x{}=1".format,
    "feedback": lambda n: f"a=rtcp-fb:{'*' if n % 2 else 96} nack",
    "sources": "a=ssrc:{} cname:x".format,
    "extensions": lambda n: f"a=extmap:{n + 1} {EXTENSIONS[n % len(EXTENSIONS)]}",
    "names": "a=mid:{}".format,
    "codecs": lambda n: f"a=rtpmap:{128 + n} VP8/90000",
}


@pytest.mark.parametrize("what", MANY)
def test_what_aiortc_reads_is_bounded(what: str) -> None:
    """The work of aiortc's parser is bounded, however many lines five pictures have."""
    line = MANY[what]
    more = "".join(line(n) + "\r\n" for n in range(75))
    picture = "m=video 9 UDP/TLS/RTP/SAVPF 96\r\na=rtpmap:96 VP8/90000\r\n" + more
    offer = BROWSERS["chromium"] + picture * 4
    assert clean_offer(offer, None, {"opus", "vp8"}).count("\n") < 150
    with counted() as steps:
        SessionDescription.parse(clean_offer(offer, None, {"opus", "vp8"}))
    assert steps.count < 150_000


def test_a_page_has_room_for_cameras() -> None:
    """An offer may have four additional cameras, each with as many lines as Chromium writes."""
    camera = "m=video 9 UDP/TLS/RTP/SAVPF 96\r\n" + "a=x\r\n" * 103
    assert pictures(clean_offer(BROWSERS["chromium"] + camera * 4)) == 5
    assert pictures(clean_offer(GOOD)) == 1


def test_each_section_has_its_own_payload_types() -> None:
    """Sound and picture may use the same number, and each may have feedback for all codecs."""
    more = "a=rtpmap:96 x/90000\r\n" + "a=rtcp-fb:* nack\r\n" * 16
    clean_offer(GOOD.replace("m=video", more + "m=video").replace("m=app", more + "m=app"))


@pytest.mark.parametrize("size", ["1", "100", "560", "65535"])
@pytest.mark.parametrize("end", ["\r\n", "\n", "\u2028", "\r"])
def test_an_offer_with_a_small_message_size_is_refused(size: str, end: str) -> None:
    """An offer that allows only small messages is refused, whatever its line endings."""
    with pytest.raises(SignallingError, match=f"messages to {size} bytes"):
        clean_offer(GOOD + f"a=x{end}a=max-message-size:{size}\r\n")


@pytest.mark.parametrize("size", ["0", "65536", "262144", "1073741823"])
def test_browsers_message_sizes_are_accepted(size: str) -> None:
    """Browsers' limits pass, and so do none and 0, which means no limit (RFC 8841)."""
    assert f"a=max-message-size:{size}" in clean_offer(GOOD + f"a=max-message-size:{size}\r\n")
    clean_offer(GOOD)


@pytest.mark.parametrize("size", ["", "-1", "1e9", " 560", "5_60", "٥٦٠"])
def test_a_message_size_that_is_no_number_is_refused(size: str) -> None:
    """A malformed message size is refused, as aiortc might read it differently."""
    with pytest.raises(SignallingError, match="max-message-size that is not a number"):
        clean_offer(GOOD + f"a=max-message-size:{size}\r\n")


@given(st.text(max_size=400) | st.text(max_size=400).map(lambda text: "v=0\n" + text))
def test_any_text_is_cleaned_or_refused(text: str) -> None:
    """No text raises anything but a refusal."""
    try:
        clean_offer(text)
    except SignallingError:
        pass
    else:
        assert text.startswith("v=0")


def test_firefox_is_known_by_its_origin() -> None:
    """Only the origin line counts, not what else an offer names."""
    firefox = "v=0\r\no=mozilla...THIS_IS_SDPARTA-99.0 1 0 IN IP4 0.0.0.0\r\ns=-\r\n"
    assert is_firefox(firefox)
    assert not is_firefox("v=0\r\no=- 1 2 IN IP4 127.0.0.1\r\ns=mozilla o=mozilla\r\n")
