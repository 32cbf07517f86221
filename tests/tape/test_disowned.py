"""Which turns are not to be used, by the events of the tape."""

from __future__ import annotations

from wax.protocol.tape_events import Disowned, TapeEvent, Turned
from wax.tape.disowned import DisownedTurns, is_within


def spans(*events: tuple[float, TapeEvent]) -> list[tuple[float, float]]:
    turns = DisownedTurns()
    for at_s, event in events:
        turns.add(at_s, event)
    return turns.spans


def turned(number: int, operator: int | None = 7) -> Turned:
    return Turned(number=number, operator=operator, why=None if operator else "expired")


def test_a_turn_is_disowned_from_its_beginning_to_its_end() -> None:
    """Though each part repeats the newest turn, and the operator says it later."""
    told: list[tuple[float, TapeEvent]] = [
        (1.0, turned(3)),
        (5.0, turned(3)),
        (9.0, turned(3, None)),
        (10.0, turned(3, None)),
        (11.0, turned(4)),
        (12.0, Disowned(turn=3)),
    ]
    assert spans(*told) == [(1.0, 9.0)]
    assert [is_within(at_s, [(1.0, 9.0)]) for at_s in (0.9, 1.0, 9.0, 9.1)] == [
        False,
        True,
        True,
        False,
    ]


def test_the_newest_turn_of_a_number_is_meant() -> None:
    """Turns count from 1 again after each start; an end that is missing is the next beginning."""
    told: list[tuple[float, TapeEvent]] = [
        (1.0, turned(1)),
        (2.0, turned(2)),
        (3.0, turned(1)),
        (4.0, turned(1, None)),
    ]
    assert spans(*told, (5.0, Disowned(turn=1))) == [(3.0, 4.0)]
    assert spans(*told, (5.0, Disowned(turn=2))) == [(2.0, 3.0)]
    assert spans(*told, (5.0, Disowned(turn=9))) == []
