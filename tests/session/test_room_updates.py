"""Updates of the room: no change is lost, and nobody can make them expensive."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.session.room_states import line, room

from wax.protocol import messages, room_change
from wax.sentence import says
from wax.session.room_updates import RoomUpdates

VIEWERS = 12
ROUND_S = 0.05


def _sent(update: messages.RoomChange) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(room_change.text_of(update))
    return found


rooms = st.builds(
    lambda found, number, volts: room(
        *(line(n, name=name, wait_s=wait_s) for n, (name, wait_s) in sorted(found.items())),
        turn=messages.TurnInfo(number=number),
        robot=messages.RobotStatus(connected=True, battery_v=volts),
    ),
    st.dictionaries(st.integers(1, 5), st.tuples(st.sampled_from("ABC"), st.integers(0, 3))),
    st.integers(0, 2),
    st.sampled_from([7.3, 7.4]),
)


@given(rooms, rooms)
def test_a_change_leads_from_the_earlier_state_to_the_later(
    before: messages.RoomState, after: messages.RoomState
) -> None:
    """For any two states, the change leads from one to the other."""
    change = room_change.between(before, after)
    assert room_change.applied(before.model_dump(), _sent(change)) == after.model_dump()


@given(st.lists(st.tuples(rooms, st.floats(0, 3)), min_size=1, max_size=20))
def test_everybody_has_the_last_state_in_the_end(
    steps: list[tuple[messages.RoomState, float]],
) -> None:
    """A page that was there from the start, or joins at any time, has the last state 5 s later."""
    updates, now_s = RoomUpdates(0.0), 0.0
    known: list[dict[str, Any]] = []
    for state, after_s in (*steps, (steps[-1][0], 5.0), (steps[-1][0], 5.0)):
        now_s += after_s
        update = updates.next(state, now_s)
        if isinstance(update, messages.RoomChange):
            known = [room_change.applied(one, _sent(update)) for one in known]
        elif update is not None:
            known = [update.model_dump()]
        assert updates.told is not None
        known.append(updates.told.model_dump())
        assert all(one == known[0] for one in known)
    assert known[0] == steps[-1][0].model_dump()


def _bytes_a_second(change: Any, seconds: int = 10) -> float:
    """Return the bytes sent to each page while `change(n)` is the room in round n, n > 0."""
    updates = RoomUpdates(0.0)
    updates.next(change(0), 0.0)
    sent = 0
    for number in range(1, round(seconds / ROUND_S) + 1):
        update = updates.next(change(number), number * ROUND_S)
        sent += 0 if update is None else len(room_change.text_of(update))
    return sent / seconds


def _others(count: int = VIEWERS) -> list[messages.ViewerInfo]:
    return [line(number) for number in range(2, count + 1)]


FLOODS = {
    "names": lambda n: room(line(1, name=f"x{n}" * 4), *_others()),
    "joins and leaves": lambda n: room(
        line(1, role="operator" if n % 2 else "observer", place=0 if n % 2 else None),
        *_others(),
        turn=messages.TurnInfo(number=n, operator=1 if n % 2 else None),
    ),
    "places": lambda n: room(
        line(1, role="queued", place=5 + n % 2),
        *(line(k, role="queued", place=k - 1, wait_s=60 * k - n // 20) for k in range(2, 6)),
        *_others()[4:],
    ),
    "comes and goes": lambda n: room(*([line(1)] if n % 2 else []), *_others()),
    "stops": lambda n: room(
        line(1),
        *_others(),
        stop=messages.StopInfo(number=n, by=says("x" * 24), viewer=n, by_host=n > 5)
        if n % 2
        else None,
    ),
}


@pytest.mark.parametrize("flood", FLOODS)
def test_a_flood_costs_the_others_little(flood: str) -> None:
    """Under 2 kB a second for each of the others, with twelve viewers and some of them waiting."""
    assert 0 < _bytes_a_second(FLOODS[flood]) <= 2000


def test_urgent_changes_are_sent_at_once() -> None:
    """Neither changes of name nor viewers who come and go delay a Stop."""
    updates, now_s = RoomUpdates(0.0), 10.0
    updates.next(room(line(1)), now_s)
    for number in range(50):
        updates.next(room(line(1, name=f"x{number}"), *_others()[: number % 9]), now_s)
    assert updates.next(room(line(1, name="y"), *_others()), now_s) is None
    stopped = room(
        line(1, name="z"),
        stop=messages.StopInfo(number=1, by=says("Bob")),
    )
    change = updates.next(stopped, now_s)
    assert isinstance(change, messages.RoomChange)
    assert change.stop == stopped.stop


def test_a_wait_is_sent_anew_when_a_turn_ends() -> None:
    """The next viewer does not read a wait that counts a turn which has ended."""
    updates = RoomUpdates(0.0)
    updates.next(room(line(1), line(2, role="queued", place=1, wait_s=40)), 0.0)
    nobody = messages.TurnInfo(number=1)
    ended = room(line(1), line(2, role="queued", place=1, wait_s=0), turn=nobody)
    updates.next(ended, 0.05)
    assert updates.told == ended
