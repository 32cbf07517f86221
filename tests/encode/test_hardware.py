"""An encoder in hardware at work, and the options by which each kind is opened."""

from __future__ import annotations

from dataclasses import replace

import av
import pytest
from av.packet import Packet
from tests.encode.encoders import GOOD, HIGH, LATE, ODD, SMALL, picture

from wax.encode.hardware import HARDWARE, Hardware, HardwareEncoder, HardwareError, is_built_in


@pytest.mark.parametrize("hardware", [GOOD, ODD])
def test_each_picture_comes_out_at_once(hardware: Hardware) -> None:
    """One in, one out, with its own time, keyframes as requested, and a decoder understands it."""
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
    """One that is not newer than the one before is none."""
    encoder = HardwareEncoder(GOOD, SMALL)
    assert encoder.encode(picture(1), keyframe=False) is not None
    assert encoder.encode(picture(1), keyframe=False) is None
    assert encoder.encode(picture(0), keyframe=True) is None


def test_one_that_keeps_pictures_is_found_out() -> None:
    """An encoder that looks ahead gives nothing for its first picture, and says so."""
    with pytest.raises(HardwareError, match="0 packets for one picture"):
        HardwareEncoder(LATE, SMALL).encode(picture(0), keyframe=True)


def test_a_picture_of_another_size_is_scaled() -> None:
    """As the processor's encoder does it."""
    encoded = HardwareEncoder(HIGH, SMALL).encode(picture(0, (320, 240)), keyframe=True)
    assert encoded is not None


def refusal(hardware: Hardware) -> str:
    """Return why it does not open here, empty if it does."""
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
    """FFmpeg ignores an option that it does not know: each is known here, and so is its value.

    A value that cannot be is refused, by an encoder that knows the option, before it looks for its
    device.
    """
    odd = replace(hardware, options={**hardware.options, option: "nonsense"})
    assert "nonsense" in refusal(odd)
    unknown = replace(hardware, options={**hardware.options, f"{option}-not": "nonsense"})
    assert "nonsense" not in refusal(unknown)
    assert "nstant" not in refusal(hardware)  # Undefined constant, as FFmpeg says


def test_what_pyav_lacks_is_known() -> None:
    """A name that is no encoder is none."""
    assert not is_built_in("h264_nonsense")
