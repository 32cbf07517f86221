"""Where parts of the tape begin: at a keyframe, and only once the last part is full."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hypothesis import given
from hypothesis import strategies as st

from wax.tape.segment_plan import SegmentPlan

if TYPE_CHECKING:
    from wax.tape.segment_plan import Kind, Step

SEGMENT_S = 60.0
KEYFRAMES_S = 10.0


def plan(*, has_camera: bool = True) -> SegmentPlan:
    return SegmentPlan(segment_s=SEGMENT_S, keyframe_interval_s=KEYFRAMES_S, has_camera=has_camera)


items = st.lists(
    st.tuples(
        st.sampled_from(["keyframe", "picture", "picture", "other"]),
        st.floats(0.0, 30.0),
    ),
    max_size=60,
)


@given(items, st.booleans())
def test_every_picture_can_be_decoded_from_its_part_alone(
    steps: list[tuple[Kind, float]], has_camera: bool
) -> None:
    """A picture is written only in a part that began with a keyframe, and never begins one."""
    planned = plan(has_camera=has_camera)
    now_s, begun_with = 0.0, None
    for kind, gap_s in steps:
        now_s += gap_s
        step = planned.decide(kind, now_s)
        if step == "begin":
            begun_with = kind
        if kind == "picture":
            assert step != "begin"
            assert (step == "write") == (begun_with == "keyframe")
        if begun_with is not None and kind != "picture":
            assert step != "skip"


@given(items)
def test_no_part_grows_without_end(steps: list[tuple[Kind, float]]) -> None:
    """Whatever arrives or stops arriving, any item but a picture ends a part that is too old."""
    planned = plan()
    now_s, began_s = 0.0, None
    for kind, gap_s in steps:
        now_s += gap_s
        if planned.decide(kind, now_s) == "begin":
            began_s = now_s
        elif kind != "picture" and began_s is not None:
            assert now_s - began_s < SEGMENT_S + KEYFRAMES_S + 1.0


def test_a_part_ends_at_the_first_keyframe_after_its_time() -> None:
    """Earlier keyframes are written like any other picture."""
    planned = plan()
    found: list[Step] = [planned.decide("keyframe", at_s) for at_s in (0.0, 10.0, 59.0, 60.0)]
    assert found == ["begin", "write", "write", "begin"]


def test_the_first_keyframe_is_waited_for_a_moment() -> None:
    """Earlier sound and events are skipped briefly, or the first part would have no picture."""
    planned = plan()
    assert planned.decide("other", 100.0) == "skip"
    assert planned.decide("other", 101.9) == "skip"
    assert planned.decide("keyframe", 101.95) == "begin"
    camera_is_dead = plan()
    assert camera_is_dead.decide("other", 100.0) == "skip"
    assert camera_is_dead.decide("other", 102.0) == "begin"
    assert camera_is_dead.decide("keyframe", 103.0) == "begin"  # it is back


def test_without_a_camera_nothing_is_waited_for() -> None:
    """Without a camera parts begin with the first sound, all with the same length."""
    planned = plan(has_camera=False)
    assert [planned.decide("other", at_s) for at_s in (0.0, 59.9, 60.0)] == [
        "begin",
        "write",
        "begin",
    ]


def test_what_has_ended_begins_with_the_next_keyframe() -> None:
    """After dropped items the next part waits for a keyframe, to be decodable."""
    planned = plan()
    planned.decide("keyframe", 0.0)
    planned.ended()
    assert planned.decide("picture", 1.0) == "skip"
    assert planned.decide("keyframe", 2.0) == "begin"
