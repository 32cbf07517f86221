"""A size of the picture that is encoded too slowly is left, and tried again later."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.late_encoding import BESIDE, LateEncoding

SIZES = ["1280x720", "640x360", "320x180"]
BUSY = [1.5, 0.6, 0.2]
IDLE = [0.5, 0.2, 0.1]

loads_of_a_second = st.lists(st.floats(0, 3), min_size=3, max_size=3)


class Machine:
    """Encodes the largest size that is sent, second after second."""

    def __init__(self) -> None:
        self.late = LateEncoding(SIZES)
        self.now_s = 100.0

    def second(self, loads: list[float], *, tape: bool = False) -> None:
        """Let one second pass; a tape has the largest size encoded all the time."""
        left = len(self.late.left)
        used = {
            size: load
            for at, (size, load) in enumerate(zip(SIZES, loads, strict=True))
            if at >= left or (tape and at == 0)
        }
        self.now_s += 1.0
        self.late.update(used, self.now_s)

    def seconds(self, count: int, loads: list[float]) -> None:
        for _ in range(count):
            self.second(loads)

    def tries(self, seconds: int, loads: list[float]) -> list[float]:
        """Return when a size was tried again."""
        found = []
        for _ in range(seconds):
            before = len(self.late.left)
            self.second(loads)
            if len(self.late.left) < before:
                found.append(self.now_s)
        return found


def test_a_burst_of_other_work_changes_nothing() -> None:
    """A size is left after more than three seconds above nine tenths of its interval."""
    machine = Machine()
    for _ in range(5):
        machine.seconds(3, BUSY)
        machine.seconds(1, IDLE)
    assert (machine.late.left, machine.late.bounded("1280x720")) == ([], "1280x720")
    machine.seconds(4, BUSY)
    assert machine.late.left == ["1280x720"]


def test_a_machine_that_is_far_behind_leaves_several_sizes_at_once() -> None:
    """A size that would be late, too, by the number of its pixels, is not tried on the way."""
    machine = Machine()
    machine.seconds(4, [5.0, 1.3, 0.4])
    assert machine.late.left == ["1280x720", "640x360"]


def test_what_is_smaller_stays_as_it_was_asked_for() -> None:
    """Only who wants more than is sent gets less."""
    machine = Machine()
    machine.seconds(4, BUSY)
    assert [machine.late.bounded(size) for size in (*SIZES, "160x90")] == [
        *("640x360", "640x360", "320x180", "160x90")
    ]


def test_a_size_that_is_still_too_slow_is_tried_ever_more_rarely() -> None:
    """The pauses double, up to a quarter of an hour, and are short again after a good minute."""
    machine = Machine()
    tries = machine.tries(6000, BUSY)
    pauses = [round(after - before) for before, after in pairwise(tries)]
    assert pauses[:4] == [64, 124, 244, 484]
    assert set(pauses[5:]) == {964}
    machine.seconds(1100, IDLE)
    assert machine.late.left == []
    first = machine.now_s
    assert machine.tries(60, BUSY)[0] - first < 40


def test_a_size_that_a_tape_needs_is_not_tried_while_it_is_slow() -> None:
    """It is encoded anyway, so that its own load says when viewers may have it again."""
    machine = Machine()
    for _ in range(1000):
        machine.second(BUSY, tape=True)
        assert machine.now_s < 104 or machine.late.left == ["1280x720"]
    machine.second(IDLE, tape=True)
    assert machine.late.left == []


def test_cameras_beside_the_view_leave_their_largest_size_first() -> None:
    """Whichever of them is late, the driving view leaves one only if that did not help."""
    for beside, view in ((0.2, 1.5), (1.5, 0.2)):
        late, now_s = LateEncoding(SIZES, has_cameras=True), 100.0
        for _ in range(4):
            late.update({BESIDE: beside, "1280x720": view}, now_s := now_s + 1.0)
        assert (late.left, late.bounded("1280x720")) == ([BESIDE], "1280x720")
        assert late.leaves_beside
        for _ in range(4):
            late.update({"1280x720": 0.95}, now_s := now_s + 1.0)
        assert (late.left, late.bounded("1280x720")) == ([BESIDE, "1280x720"], "640x360")


def test_cameras_beside_the_view_are_large_again_last() -> None:
    """A camera that nobody watches is left with the view, and comes back after it."""
    late, now_s, found = LateEncoding(SIZES, has_cameras=True), 100.0, []
    for _ in range(4):
        late.update({"1280x720": 1.5}, now_s := now_s + 1.0)
    for _ in range(70):
        late.update({"640x360": 0.2}, now_s := now_s + 1.0)
        if late.left not in found:
            found.append(late.left)
    assert found == [[BESIDE, "1280x720"], [BESIDE], []]
    assert not late.leaves_beside


@given(st.lists(st.tuples(loads_of_a_second, st.integers(1, 40)), max_size=30))
def test_the_smallest_size_is_always_sent(phases: list[tuple[list[float], int]]) -> None:
    """However late encoding is, something is sent; a size that is in time is never left."""
    machine = Machine()
    for loads, seconds in phases:
        for _ in range(seconds):
            before = machine.late.left
            used = next((load for load in loads[len(before) :] if load > 0), 0.0)
            machine.second(loads)
            assert machine.late.left == SIZES[: len(machine.late.left)] != SIZES
            assert len(machine.late.left) <= len(before) or used > 0.9


@given(loads_of_a_second)
def test_a_steady_machine_comes_to_rest(loads: list[float]) -> None:
    """In an hour of one and the same load few sizes are tried in vain."""
    machine = Machine()
    machine.seconds(20, loads)
    assert len(machine.tries(3600, loads)) <= 10


def test_nobody_watches_and_nothing_is_left() -> None:
    """Encoders that rest say nothing, and the size is there for whoever comes."""
    machine = Machine()
    machine.seconds(4, BUSY)
    machine.seconds(40, [0.0, 0.0, 0.0])
    assert machine.late.left == []
