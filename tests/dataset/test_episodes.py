"""What of a tape is an episode."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dataset.driven_tape import steered, turned

from wax.dataset.episodes import LONGEST_S, QUIET_S, Division, Episode, EpisodeFinder, LeftOut
from wax.protocol.tape_events import Faulted, Missed, Stopped, Tasked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.protocol.tape_events import TapeEvent

    Part = Sequence[tuple[float, TapeEvent]]


def stopped(*, pressed: bool) -> Stopped:
    return Stopped(number=1, pressed=pressed, viewer=2, by_host=False)


FAULTED = Faulted(operator=1, why="lost")
HELD = steered(0.0, reason="fault")
DRIVEN = steered(0.5)
STOPS: Part = [(3, stopped(pressed=True)), (5, stopped(pressed=False))]


def found(*parts: Part, joins: bool = False) -> Division:
    """Divide parts, each of which begins with its first event."""
    finder = EpisodeFinder(joins=joins)
    for events in parts:
        finder.begin_part(events[0][0])
        for at_s, event in events:
            finder.add(at_s, event)
    return finder.finish()


def spans(*parts: Part, joins: bool = False) -> list[tuple[int, float, float]]:
    return [(one.turn, one.begin_s, one.end_s) for one in found(*parts, joins=joins).episodes]


def test_an_episode_is_a_turn() -> None:
    """It lasts from the turn's beginning to its end; nobody's time between turns is in none."""
    part: Part = [(0, DRIVEN), (1, turned(1)), (5, turned(1, None)), (7, turned(2)), (9, DRIVEN)]
    assert spans(part) == [(1, 1, 5), (2, 7, 9)]


def test_a_change_of_operator_ends_an_episode() -> None:
    """The next turn begins where the last ended, even at the same moment."""
    part: Part = [(0, turned(1)), (5, turned(1, None)), (5, turned(2, 2)), (9, DRIVEN)]
    assert spans(part) == [(1, 0, 5), (2, 5, 9)]


def test_a_stop_ends_an_episode_and_its_release_begins_another() -> None:
    """What happens while Stop is pressed is left out, with the reason."""
    part: Part = [
        (0, turned(1)),
        *STOPS,
        (9, DRIVEN),
    ]
    assert spans(part) == [(1, 0, 3), (1, 5, 9)]
    assert [(one.begin_s, one.end_s, one.why) for one in found(part).left_out] == [
        (3, 5, "Stop was pressed")
    ]
    assert spans(part, joins=True) == [(1, 0, 9)]


def test_a_fault_ends_an_episode_until_the_robot_is_driven_again() -> None:
    """Set-points that the gate holds back do not end a fault."""
    part: Part = [(0, turned(1)), (3, FAULTED), (4, HELD), (6, DRIVEN), (9, DRIVEN)]
    assert spans(part) == [(1, 0, 3), (1, 6, 9)]
    assert spans(part, joins=True) == [(1, 0, 9)]


def test_a_fault_ends_with_its_turn() -> None:
    """The next operator's turn is an episode from its beginning, also in the next part."""
    faults: Part = [(0, turned(1)), (3, FAULTED)]
    assert spans([*faults, (6, turned(2)), (9, DRIVEN)]) == [(1, 0, 3), (2, 6, 9)]
    assert spans(faults, [(4, turned(2)), (9, DRIVEN)]) == [(1, 0, 3), (2, 4, 9)]


def test_a_turn_that_ends_while_stop_is_pressed_is_joined_to_its_end() -> None:
    """With the choice to go on through a Stop, the whole turn is one episode."""
    part: Part = [(0, turned(1)), (3, stopped(pressed=True)), (5, turned(1, None)), (9, DRIVEN)]
    assert spans(part, joins=True) == [(1, 0, 5)]


def test_a_part_that_only_repeats_what_lasts_counts() -> None:
    """A Stop that it repeats ends the episode, whether or not another part follows."""
    begin: Part = [(0, turned(1)), (9.5, DRIVEN)]
    short: Part = [(10, turned(1)), (10, stopped(pressed=True))]
    after: Part = [(11, turned(1)), (11, stopped(pressed=True)), (19, DRIVEN)]
    assert spans(begin, short) == spans(begin, short, after) == [(1, 0, 10)]


def test_an_episode_goes_on_in_the_next_part() -> None:
    """A part begins with what lasts: the turn, a pressed Stop; a fault lasts until it is driven."""
    begin: Part = [(0, turned(1)), (9.5, DRIVEN)]
    assert spans(begin, [(10, turned(1)), (19, DRIVEN)]) == [(1, 0, 19)]
    stops: Part = [(10.0, turned(1)), (10.0, stopped(pressed=True)), (19.0, DRIVEN)]
    assert spans([(0, turned(1)), (9.5, stopped(pressed=True))], stops) == [(1, 0, 9.5)]
    faults: Part = [(10.0, turned(1)), (10.0, HELD), (12.0, DRIVEN), (19.0, DRIVEN)]
    assert spans([(0, turned(1)), (9.5, FAULTED)], faults) == [(1, 0, 9.5), (1, 12, 19)]


def test_a_part_may_begin_before_the_last_one_ended() -> None:
    """It begins as its first picture is captured; the last goes on until that is encoded."""
    begin: Part = [(0, turned(1)), (9.9, stopped(pressed=True)), (10.05, stopped(pressed=False))]
    after: Part = [(10, turned(1)), (10, stopped(pressed=False)), (19, DRIVEN)]
    assert spans(begin, after) == [(1, 0, 9.9), (1, 10.05, 19)]
    assert spans([(0, turned(1)), (10.1, DRIVEN)], after) == [(1, 0, 19)]
    nobody: Part = [(10, DRIVEN), (12, DRIVEN)]
    assert spans([(0, turned(1)), (10.1, DRIVEN)], nobody) == [(1, 0, 10.1)]


def test_a_server_that_starts_anew_ends_an_episode() -> None:
    """A part that does not repeat the turn is of another server, however soon it began."""
    assert spans(
        [(0, turned(1)), (9.5, DRIVEN)], [(10, DRIVEN), (12, turned(1)), (14, DRIVEN)]
    ) == [
        (1, 0, 10),
        (1, 12, 14),
    ]


@pytest.mark.parametrize("began_s", [9.5 + QUIET_S + 0.1, 8.0])
def test_a_gap_and_a_clock_step_end_an_episode(began_s: float) -> None:
    """A part that begins later than the last ended, or before it, continues nothing."""
    parts: list[Part] = [
        [(0, turned(1)), (9.5, DRIVEN)],
        [(began_s, turned(1)), (19, DRIVEN)],
    ]
    assert spans(*parts) == [(1, 0, 9.5), (1, began_s, 19)]


def test_what_the_disk_was_too_slow_for_is_in_no_episode() -> None:
    """The time that an event calls missed is left out."""
    part: Part = [(0, turned(1)), (2, DRIVEN), (9, Missed(missed_s=5.0)), (12, DRIVEN)]
    assert spans(part) == [(1, 0, 4), (1, 9, 12)]


def test_a_long_turn_is_divided() -> None:
    """A turn that is renewed for hours is several episodes without a gap."""
    part: Part = [(0, turned(1)), (2 * LONGEST_S + 100, DRIVEN)]
    assert spans(part) == [
        (1, 0, LONGEST_S),
        (1, LONGEST_S, 2 * LONGEST_S),
        (1, 2 * LONGEST_S, 2 * LONGEST_S + 100),
    ]


def test_an_episode_has_the_task_that_its_operator_said() -> None:
    """It is that of the turn, also in the next part, and never of the turn after it."""
    first: Part = [(0, turned(1)), (1, Tasked(turn=1, text="Tidy up")), (9, DRIVEN)]
    second: Part = [(10, turned(1)), (10, Tasked(turn=1, text="Tidy up")), (12, turned(2, 2))]
    division = found(first, [*second, (13, Tasked(turn=1, text="late")), (15, DRIVEN)])
    assert [(one.turn, one.task) for one in division.episodes] == [(1, "Tidy up"), (2, "")]


def test_an_episode_is_clipped_to_the_time_asked_for() -> None:
    """Only what lies within the time is left of it, nothing of one outside."""
    episode = Episode(1, 10.0, 20.0)
    assert episode.within(12.0, 15.0) == Episode(1, 12.0, 15.0)
    assert episode.within(20.0, 30.0) is None


EVENTS = st.one_of(
    st.builds(turned, st.integers(1, 4), st.sampled_from([None, 1, 2])),
    st.builds(stopped, pressed=st.booleans()),
    st.sampled_from([FAULTED, HELD, DRIVEN]),
    st.builds(Missed, missed_s=st.floats(0, 5)),
)


@given(
    st.lists(st.lists(st.tuples(st.floats(0, 3), EVENTS), min_size=1), min_size=1),
    st.booleans(),
)
def test_episodes_never_overlap_and_hold_one_turn(
    parts: list[list[tuple[float, TapeEvent]]], joins: bool
) -> None:
    """Whatever happens, episodes and what is left out are disjoint, and each is in its own turn."""
    now_s, placed = 0.0, []
    for part in parts:
        at_s = [now_s := now_s + after_s for after_s, _ in part]
        placed.append(list(zip(at_s, (event for _, event in part), strict=True)))
    division = found(*placed, joins=joins)
    both: list[Episode | LeftOut] = [*division.episodes, *division.left_out]
    every = sorted(both, key=lambda one: (one.begin_s, one.end_s))
    assert all(one.begin_s < one.end_s for one in every)
    assert all(before.end_s <= after.begin_s for before, after in pairwise(every))
    turns = [(at_s, event) for part in placed for at_s, event in part if event.type == "turned"]
    for one in division.episodes:
        begins = [event for at_s, event in turns if at_s <= one.begin_s]
        assert begins
        within = [event for at_s, event in turns if one.begin_s < at_s < one.end_s]
        assert {(event.number, event.operator is None) for event in within} <= {(one.turn, False)}
