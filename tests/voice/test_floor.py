"""The floor: one permitted speaker at a time."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.voice.floor import Floor, VoiceVerdict


def judge(
    floor: Floor, who: int, now_s: float, *, may: bool = True, muted: bool = False
) -> VoiceVerdict:
    return floor.judge(who, now_s, may_speak=may, is_muted=muted, is_played=True)


def test_who_begins_is_heard_and_the_other_waits() -> None:
    """The first speaker keeps the floor until they have paused for half a second."""
    floor = Floor()
    assert judge(floor, 1, 10.0) is VoiceVerdict.HEARD
    assert judge(floor, 2, 10.1) is VoiceVerdict.TAKEN
    floor.sounded(1, 10.4)
    assert judge(floor, 2, 10.8) is VoiceVerdict.TAKEN
    assert judge(floor, 2, 10.91) is VoiceVerdict.HEARD
    assert judge(floor, 1, 11.0) is VoiceVerdict.TAKEN


def test_silence_keeps_the_floor_from_nobody() -> None:
    """An open microphone in a quiet room is heard, but yields to a voice."""
    floor = Floor()
    for step in range(100):
        assert judge(floor, 1, 10 + step / 50) is VoiceVerdict.HEARD
    assert judge(floor, 2, 12.0) is VoiceVerdict.HEARD
    assert judge(floor, 1, 12.1) is VoiceVerdict.TAKEN


def test_who_loses_the_right_loses_the_floor() -> None:
    """A speaker who loses permission loses the floor at once."""
    floor = Floor()
    judge(floor, 1, 10.0)
    assert judge(floor, 1, 10.1, may=False) is VoiceVerdict.NOT_ALLOWED
    assert judge(floor, 2, 10.1) is VoiceVerdict.HEARD
    assert judge(floor, 2, 10.2, muted=True) is VoiceVerdict.MUTED
    assert floor.holder(10.2) is None


def test_without_a_speaker_nobody_has_the_floor() -> None:
    """Nobody gets the floor while the robot's loudspeaker does not play."""
    floor = Floor()
    verdict = floor.judge(1, 10.0, may_speak=True, is_muted=False, is_played=False)
    assert verdict is VoiceVerdict.NO_SPEAKER
    assert floor.holder(10.0) is None


STEP = st.tuples(
    st.integers(1, 3), st.floats(0, 0.7), st.booleans(), st.booleans(), st.booleans(), st.booleans()
)


@examples(400)
@given(st.lists(STEP, max_size=60))
def test_never_two_and_never_who_may_not(
    steps: list[tuple[int, float, bool, bool, bool, bool]],
) -> None:
    """Whoever is heard has permission, and nobody else sounded in the last half second."""
    floor = Floor()
    now_s = 0.0
    for who, pause_s, may, muted, played, sounds in steps:
        now_s += pause_s
        holder = floor.holder(now_s)
        verdict = floor.judge(who, now_s, may_speak=may, is_muted=muted, is_played=played)
        if verdict is VoiceVerdict.HEARD:
            assert may
            assert played
            assert not muted
            assert holder in (None, who)
            assert floor.holder(now_s) in (None, who)
            if sounds:
                floor.sounded(who, now_s)
                assert floor.holder(now_s) == who
