"""The ablation: which constants there are, what it says about them, and how it changes one."""

from __future__ import annotations

from tests.ablation.constants import Constant, constants
from tests.ablation.sweep import BOUNDS, ELSEWHERE, FACTS, Result, effect, means, tuned

from wax.congestion import estimator, pacer

ALL = constants()


def _named(key: str) -> Constant:
    (found,) = [one for one in ALL if one.key == key]
    return found


def test_each_constant_says_why() -> None:
    """Each number has a docstring with its reason."""
    assert [one.key for one in ALL if not one.note] == []


def test_what_is_left_out_exists() -> None:
    """Every named exception exists, and only these constants are left out."""
    left_out = FACTS | BOUNDS | ELSEWHERE
    assert {one.key for one in ALL} >= left_out
    assert {one.key for one in tuned()} == {one.key for one in ALL} - left_out


def test_a_constant_is_changed_wherever_it_is_known_and_put_back() -> None:
    """Modules that have imported a constant see the change, too, until it is undone."""
    constant = _named("pacer.STARTING_RATE_BPS")
    with constant.set(constant.scaled(2.0)):
        assert [vars(one)[constant.name] for one in (pacer, estimator)] == [600_000, 600_000]
    assert [vars(one)[constant.name] for one in (pacer, estimator)] == [300_000, 300_000]


def test_whole_numbers_stay_whole() -> None:
    """Half of three trains is two, and half of one is one."""
    assert _named("estimator._STARTUP_TRAINS").scaled(0.5) == 2
    assert Constant("m", "N", 1, None).scaled(0.5) == 1
    assert Constant("m", "N", (30.0, 480.0), None).scaled(2.0) == (60.0, 960.0)


def test_the_largest_change_is_what_is_told() -> None:
    """The largest change over links and measures is reported, unless chance explains it."""
    before: Result = {
        "modem": {"use": 0.8, "sound_ms": 100.0},
        "cell": {"use": 0.5, "sound_ms": 80.0},
    }
    after: Result = {
        "modem": {"use": 0.79, "sound_ms": 180.0},
        "cell": {"use": 0.5, "sound_ms": 95.0},
    }
    chance: Result = {link: dict.fromkeys(measures, 0.0) for link, measures in before.items()}
    assert effect(before, after, chance) == "modem: sound 100 ms → 180 ms"
    assert effect(before, before, chance) == "the same"
    loud: Result = {link: dict.fromkeys(measures, 100.0) for link, measures in before.items()}
    assert effect(before, after, loud) == "no change to speak of"


def test_means_are_of_the_runs_that_have_a_measure() -> None:
    """A run without a picture neither counts as age 0 nor hides the others."""
    runs: list[Result] = [{"modem": {"use": use, "picture_ms": None}} for use in (0.4, 0.6)]
    runs[1]["modem"]["picture_ms"] = 80.0
    assert means(runs) == {"modem": {"use": 0.5, "picture_ms": 80.0}}
