"""A receiver's queue: in order, retried later, and expired at last."""

from __future__ import annotations

from wax.hooks.outbox import KEPT_S, MOST, Message, Outbox
from wax.sentence import Sentence

WHY = Sentence("hook.answers", {"status": "500"})


def message(number: int, at_s: float = 0.0) -> Message:
    return Message(f"msg_{number}", "queue.empty", b"{}", at_s)


def test_all_come_in_order() -> None:
    """No message overtakes another, and each is delivered once."""
    box = Outbox()
    first, second = message(1), message(2)
    box.put(first)
    box.put(second)
    assert box.due(0.0) is first
    assert box.due(0.0) is first
    box.delivered(first)
    assert box.due(0.0) is second
    box.delivered(second)
    assert box.due(0.0) is None
    assert (box.taken, box.lost, len(box)) == (2, 0, 0)


def test_a_failure_is_tried_again_less_and_less_often() -> None:
    """The backoff is 1, 2, 4 … and at most 60 s; a delivery resets it."""
    box, now_s = Outbox(), 0.0
    box.put(message(1))
    waits = []
    for _ in range(9):
        box.failed(WHY, now_s)
        began_s = now_s
        while box.due(now_s) is None:
            now_s += 0.5
        waits.append(now_s - began_s)
    assert waits == [1, 2, 4, 8, 16, 32, 60, 60, 60]
    assert box.problem == WHY
    box.delivered(message(1))
    assert box.problem is None
    box.failed(WHY, now_s)
    assert box.due(now_s + 1.0) is not None


def test_after_ten_minutes_it_is_lost() -> None:
    """A message that expires is counted as lost; a younger one stays."""
    box = Outbox()
    box.put(message(1, 0.0))
    young = message(2, 100.0)
    box.put(young)
    assert box.due(KEPT_S) is not None
    assert box.due(KEPT_S + 1) is young
    assert (box.lost, len(box)) == (1, 1)


def test_of_too_many_the_oldest_are_lost() -> None:
    """The queue is bounded however many events come while the receiver is away."""
    box = Outbox()
    for number in range(MOST + 50):
        box.put(message(number))
    assert (len(box), box.lost) == (MOST, 50)
    assert box.first is not None
    assert box.first.id == "msg_50"


def test_what_was_pushed_out_on_its_way_takes_no_other_with_it() -> None:
    """A message dropped in flight that arrives after all removes no other from the queue."""
    box = Outbox()
    under_way = message(0)
    box.put(under_way)
    for number in range(1, MOST + 1):
        box.put(message(number))
    box.delivered(under_way)
    assert len(box) == MOST
    assert box.first is not None
    assert box.first.id == "msg_1"
