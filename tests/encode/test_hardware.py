"""A hardware encoder in use, and the options for opening each kind."""

from __future__ import annotations

from dataclasses import replace

import av
import pytest
from av.packet import Packet
from tests.encode.encoders import GOOD, HIGH, LATE, ODD, SMALL, picture

from wax.encode.hardware import HARDWARE, Hardware, HardwareEncoder, HardwareError, is_built_in


@pytest.mark.parametrize("hardware", [GOOD, ODD])
def test_each_picture_comes_out_at_once(hardware: Hardware) -> None:
    """Each picture yields one decodable packet with its own time, keyframes on request."""
    encoder = HardwareEncoder(hardware, SMALL)
    decoder = av.CodecContext.create("h264", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    for number in range(20):
        source = picture(number)
        encoded = encoder.encode(source, keyframe=number == 12)
        assert encoded is not None
        assert encoded.captured_s == source.captured_s
        assert encoded.pts == round(source.captured_s * 90_000)
        assert encoded.keyframe == (number in (0, 12))
        (frame,) = decoder.decode(Packet(encoded.data))
        assert (frame.width, frame.height) == (160, 120)


def test_an_old_picture_is_left_out() -> None:
    """A picture that is not newer than the last is skipped."""
    encoder = HardwareEncoder(GOOD, SMALL)
    assert encoder.encode(picture(1), keyframe=False) is not None
    assert encoder.encode(picture(1), keyframe=False) is None
    assert encoder.encode(picture(0), keyframe=True) is None


def test_one_that_keeps_pictures_is_found_out() -> None:
    """An encoder that looks ahead returns nothing for its first picture, which is an error."""
    with pytest.raises(HardwareError, match="0 packets for one picture"):
        HardwareEncoder(LATE, SMALL).encode(picture(0), keyframe=True)


def test_a_picture_of_another_size_is_scaled() -> None:
    """Hardware scales pictures as the software encoder does."""
    encoded = HardwareEncoder(HIGH, SMALL).encode(picture(0, (320, 240)), keyframe=True)
    assert encoded is not None


def refusal(hardware: Hardware) -> str:
    """Return why the encoder does not open here; empty if it does."""
    av.logging.set_level(av.logging.ERROR)
    av.logging.set_skip_repeated(False)
    try:
        HardwareEncoder(hardware, SMALL)
    except HardwareError as error:
        return str(error)
    finally:
        av.logging.set_skip_repeated(True)
        av.logging.set_level(None)
    return ""


@pytest.mark.parametrize(
    ("hardware", "option"),
    [(one, option) for one in HARDWARE for option in one.options],
    ids=lambda one: one.name if isinstance(one, Hardware) else one,
)
def test_each_option_is_known(hardware: Hardware, option: str) -> None:
    """FFmpeg ignores unknown options, so each option and its value are checked to be known.

    An encoder that knows an option rejects an impossible value before it looks for its device.
    """
    odd = replace(hardware, options={**hardware.options, option: "nonsense"})
    assert "nonsense" in refusal(odd)
    unknown = replace(hardware, options={**hardware.options, f"{option}-not": "nonsense"})
    assert "nonsense" not in refusal(unknown)
    assert "nstant" not in refusal(hardware)  # "Undefined constant" in FFmpeg's words


def test_what_pyav_lacks_is_known() -> None:
    """An unknown name is reported as not built in."""
    assert not is_built_in("h264_nonsense")
