"""Offers: what delays the answer is left out, what cannot be answered gets a sentence."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.errors import SignallingError
from wax.rtc.signalling import MAX_SDP_CHARS, clean_offer, is_firefox

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


def test_names_that_cannot_be_resolved_are_left_out() -> None:
    """MDNS candidates and the end of candidates go, everything else stays in order."""
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
        (GOOD.replace("m=video", "m=vide0"), "one picture section, it has 0"),
        (GOOD + "m=audio 9 UDP/TLS/RTP/SAVPF 0\r\n", "one sound section, it has 2"),
    ],
)
def test_what_cannot_be_answered_gets_a_sentence(sdp: str, says: str) -> None:
    """A bad offer is refused with the reason."""
    with pytest.raises(SignallingError, match=says):
        clean_offer(sdp)


@given(st.text(max_size=400) | st.text(max_size=400).map(lambda text: "v=0\n" + text))
def test_any_text_is_cleaned_or_refused(text: str) -> None:
    """No text whatever raises anything but a refusal."""
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
