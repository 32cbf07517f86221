"""A keyframe without parameter sets gets the last known ones."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from tests.encode.encoders import SMALL, picture

from wax.encode.parameter_sets import ParameterSets, can_start_decoder, profile, units
from wax.encode.video_encoder import VideoEncoder

START = b"\x00\x00\x00\x01"


def _keyframe() -> bytes:
    encoder = VideoEncoder(codec="h264", rendition=SMALL)
    found = encoder.encode(picture(0), keyframe=True)
    assert found is not None
    return found.data


def _bare(data: bytes) -> bytes:
    """Return a keyframe as some hardware outputs it after the first one."""
    return b"".join(START + unit for unit in units(data) if unit[0] & 31 not in (7, 8))


def test_a_later_keyframe_gets_them() -> None:
    """A decoder can start at the second keyframe as at the first."""
    whole = _keyframe()
    sets = ParameterSets()
    assert sets.prepend_to(whole) == whole
    assert not can_start_decoder(_bare(whole))
    assert can_start_decoder(sets.prepend_to(_bare(whole)))


def test_they_may_come_beside_the_stream() -> None:
    """Parameter sets that an encoder reports when opened count, too."""
    whole = _keyframe()
    head = b"".join(START + unit for unit in units(whole) if unit[0] & 31 in (7, 8))
    assert can_start_decoder(ParameterSets(head).prepend_to(_bare(whole)))


def test_without_any_nothing_is_changed() -> None:
    """Without known parameter sets a keyframe is unchanged, and no decoder can start there."""
    bare = _bare(_keyframe())
    assert ParameterSets().prepend_to(bare) == bare


def test_the_profile_is_read() -> None:
    """Our profile is baseline; data without parameter sets has none."""
    assert profile(_keyframe()) == 66
    assert profile(_bare(_keyframe())) is None


@given(st.binary(max_size=60))
def test_any_bytes_are_no_problem(data: bytes) -> None:
    """Any bytes, which a driver might return, are handled."""
    assert ParameterSets(data).prepend_to(data).endswith(data)
    can_start_decoder(data)
    profile(data)
