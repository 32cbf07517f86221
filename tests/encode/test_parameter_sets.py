"""Parameter sets: a keyframe without them gets those that came before."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from tests.encode.encoders import SMALL, picture

from wax.encode.parameter_sets import ParameterSets, can_begin, profile, units
from wax.encode.video_encoder import VideoEncoder

START = b"\x00\x00\x00\x01"


def _keyframe() -> bytes:
    encoder = VideoEncoder(codec="h264", rendition=SMALL)
    found = encoder.encode(picture(0), keyframe=True)
    assert found is not None
    return found.data


def _bare(data: bytes) -> bytes:
    """Return a keyframe as some hardware gives it after the first one."""
    return b"".join(START + unit for unit in units(data) if unit[0] & 31 not in (7, 8))


def test_a_later_keyframe_gets_them() -> None:
    """Who comes at the second keyframe can begin there, as at the first."""
    whole = _keyframe()
    sets = ParameterSets()
    assert sets.before(whole) == whole
    assert not can_begin(_bare(whole))
    assert can_begin(sets.before(_bare(whole)))


def test_they_may_come_beside_the_stream() -> None:
    """What an encoder tells when it is opened counts, too."""
    whole = _keyframe()
    head = b"".join(START + unit for unit in units(whole) if unit[0] & 31 in (7, 8))
    assert can_begin(ParameterSets(head).before(_bare(whole)))


def test_without_any_nothing_is_changed() -> None:
    """A keyframe to which none have ever come stays as it is, and nobody can begin there."""
    bare = _bare(_keyframe())
    assert ParameterSets().before(bare) == bare


def test_the_profile_is_read() -> None:
    """Ours is baseline; what has no parameter set has none."""
    assert profile(_keyframe()) == 66
    assert profile(_bare(_keyframe())) is None


@given(st.binary(max_size=60))
def test_any_bytes_are_no_problem(data: bytes) -> None:
    """A driver may give anything."""
    assert ParameterSets(data).before(data).endswith(data)
    can_begin(data)
    profile(data)
