"""Who goes first, by how long each has driven."""

from __future__ import annotations

from typing import Any

from wax.config.turns import TurnSettings
from wax.control.fairness import WINDOW_S, Fairness, Person

ANN, BOB = Person("ann", "home"), Person("bob", "school")
EVE = Person("eve", "school")
HOST = Person("friend", "afar", is_invited=True)


def make(**settings: Any) -> Fairness:
    return Fairness(TurnSettings.model_validate(settings))


def test_everybody_is_equal_at_first() -> None:
    """Without rules, earlier turns change nothing."""
    fairness = make(invited_first=False)
    fairness.record(ANN, 0.0, 60.0)
    assert fairness.rank(ANN, 61.0) == fairness.rank(BOB, 61.0) == fairness.rank(HOST, 61.0)


def test_a_cool_down_lets_others_go_first() -> None:
    """A cool-down starts when the turn ends, and lasts for its configured time."""
    fairness = make(cooldown_s=30.0)
    fairness.record(ANN, 0.0, 60.0)
    assert fairness.rank(BOB, 89.0) < fairness.rank(ANN, 89.0)
    assert fairness.rank(BOB, 90.0) == fairness.rank(ANN, 90.0)


def test_the_invited_go_first() -> None:
    """If so configured, invited people go first, but not before people whose cool-down is over."""
    fairness = make(cooldown_s=30.0)
    assert fairness.rank(HOST, 0.0) < fairness.rank(ANN, 0.0)
    fairness.record(HOST, 0.0, 60.0)
    assert fairness.rank(ANN, 70.0) < fairness.rank(HOST, 70.0)


def test_a_persons_share() -> None:
    """Ann drove two thirds of the time: more than half."""
    fairness = make(max_share_per_person=0.5)
    fairness.record(ANN, 0.0, 60.0)
    fairness.record(BOB, 60.0, 120.0)
    assert fairness.rank(ANN, 120.0) == fairness.rank(BOB, 120.0)
    fairness.record(ANN, 120.0, 180.0)
    assert fairness.rank(BOB, 180.0) < fairness.rank(ANN, 180.0)
    assert fairness.may_be_overtaken(ANN, 180.0)


def test_an_addresss_share() -> None:
    """People at one address share a limit, even those who have never driven."""
    fairness = make(max_share_per_address=0.5)
    fairness.record(BOB, 0.0, 60.0)
    assert fairness.rank(ANN, 60.0) < fairness.rank(EVE, 60.0)


def test_what_is_long_ago_is_forgotten() -> None:
    """Turns count towards a share for an hour."""
    fairness = make(max_share_per_person=0.5)
    fairness.record(ANN, 0.0, 60.0)
    assert fairness.may_be_overtaken(ANN, WINDOW_S + 59.0)
    assert not fairness.may_be_overtaken(ANN, WINDOW_S + 60.0)


def test_what_is_kept_does_not_grow_with_turns() -> None:
    """Memory does not grow with the number of turns: only the last hour is kept."""
    fairness = make(max_share_per_person=0.5)
    people = [Person(str(number)) for number in range(20)]
    for number in range(100_000):
        fairness.record(people[number % 20], number * 0.1, number * 0.1 + 0.1)
    assert sum(len(minute.driven_ms) for minute in fairness._minutes) <= 20 * (WINDOW_S / 60 + 1)
    assert fairness._all_ms <= (WINDOW_S + 60.0) * 1000


def test_nobody_is_kept_for_longer_than_an_hour() -> None:
    """People are forgotten an hour after their last turn."""
    fairness = make(cooldown_s=3600.0, max_share_per_person=0.5)
    for number in range(10_000):
        fairness.record(Person(str(number)), number * 10.0, number * 10.0 + 10.0)
    kept = fairness._last_s, fairness._by_person_ms
    assert all(len(each) <= WINDOW_S / 10.0 + 6 for each in kept)
    assert not fairness.may_be_overtaken(ANN, 100_020.0 + WINDOW_S)
    assert [len(each) for each in (*kept, fairness._by_address_ms, fairness._minutes)] == [0] * 4
    assert fairness._all_ms == 0
