"""How fresh the operator's picture is."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from tests.control.rules import RULES, VOUCHED

from wax.control.turn_view import TurnView
from wax.control.video_freshness import VideoFreshness, credible_seen_s, judge

TURN = TurnView(number=1, operator=1, present=True, one_way_s=0.125, sees=True, picture=VOUCHED)


@pytest.mark.parametrize(
    ("seen_s", "expected"),
    [
        (10.0, VideoFreshness.CLEAR),
        (10.0 - 0.524, VideoFreshness.CLEAR),
        (10.0 - 0.526, VideoFreshness.LATE),
        (10.0 - 0.924, VideoFreshness.LATE),
        (10.0 - 0.926, VideoFreshness.NONE),
        (None, VideoFreshness.NONE),
        (math.nan, VideoFreshness.NONE),
        (-math.inf, VideoFreshness.NONE),
    ],
)
def test_age_of_the_picture(seen_s: float | None, expected: VideoFreshness) -> None:
    """A picture is late or too late beyond the limits plus the link's delay."""
    assert judge(seen_s, 10.0, TURN, RULES) is expected


def test_unknown_delay_is_no_allowance() -> None:
    """Until the link's delay is measured, the limits have no allowance."""
    unknown = replace(TURN, one_way_s=None)
    assert judge(10.0 - 0.399, 10.0, unknown, RULES) is VideoFreshness.CLEAR
    assert judge(10.0 - 0.401, 10.0, unknown, RULES) is VideoFreshness.LATE
    assert judge(10.0 - 0.801, 10.0, unknown, RULES) is VideoFreshness.NONE
    assert judge(0.0, 0.4, unknown, RULES) is VideoFreshness.CLEAR
    assert judge(0.0, 0.8, unknown, RULES) is VideoFreshness.LATE


@pytest.mark.parametrize("seen_s", [None, 0.0, 10.0])
def test_picture_off_on_purpose(seen_s: float | None) -> None:
    """With the picture switched off an operator sees none on purpose, whatever the page reports."""
    assert judge(seen_s, 10.0, replace(TURN, sees=False), RULES) is VideoFreshness.OFF


@pytest.mark.parametrize(
    ("seen_s", "expected_s"),
    [
        (9.0, 9.0),
        (10.0, 10.0),
        (10.1, 10.0),
        (10.176, None),
        (None, None),
        (math.nan, None),
        (math.inf, None),
    ],
)
def test_what_is_believed(seen_s: float | None, expected_s: float | None) -> None:
    """A picture time slightly ahead counts as now, one far ahead as no picture."""
    assert credible_seen_s(seen_s, 10.0, 0.125) == expected_s
