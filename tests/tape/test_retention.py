"""What is deleted from the tape: the oldest first, and never what the host keeps."""

from __future__ import annotations

from typing import Final

from hypothesis import given
from hypothesis import strategies as st

from wax.tape.retention import Keeper, Part, retain

DAY_S = 86_400.0
NOW_S = 1000 * DAY_S

KEEPERS: Final[tuple[Keeper | None, ...]] = (None, None, "host", "operator", "fault")

parts_of_a_tape = st.lists(
    st.tuples(
        st.floats(0.0, 20.0),
        st.integers(0, 100),
        st.sampled_from(KEEPERS),
        st.booleans(),
    ),
    max_size=12,
).map(
    lambda drawn: [
        Part(f"{number}", NOW_S - age_days * DAY_S, size, kept, is_open)
        for number, (age_days, size, kept, is_open) in enumerate(sorted(drawn, key=_oldest_first))
    ]
)


def _oldest_first(drawn: tuple[float, int, object, bool]) -> float:
    return -drawn[0]


@given(parts_of_a_tape, st.integers(0, 400), st.floats(0.1, 30.0))
def test_what_stays_is_within_its_limits(
    parts: list[Part], max_bytes: int, keep_days: float
) -> None:
    """No protected part goes, no expired part stays, and no more goes than necessary."""
    verdict = retain(parts, now_s=NOW_S, max_bytes=max_bytes, keep_days=keep_days)
    gone = [one for one in parts if one.name in verdict.gone]
    left = [one for one in parts if one.name not in verdict.gone]
    assert not any(one.kept == "host" or one.is_open for one in gone)
    assert sum(one.size_bytes for one in left) == verdict.left_bytes
    fixed = [one for one in left if one.kept == "host" or one.is_open]
    loose = [one for one in left if one not in fixed]
    assert all(NOW_S - one.ended_s <= keep_days * DAY_S for one in loose)
    if verdict.left_bytes > max_bytes:
        assert loose == []
    # Young unkept parts go in order, and without the last of them the size was exceeded.
    young = [one for one in gone if NOW_S - one.ended_s <= keep_days * DAY_S]
    if any(one.kept is not None for one in young):
        assert not any(one.kept is None for one in loose)


def part(name: str, age_days: float, **more: object) -> Part:
    return Part(name, NOW_S - age_days * DAY_S, 10, **more)  # type: ignore[arg-type]  # the rest's


def test_a_fault_outlives_what_is_younger_and_not_kept() -> None:
    """Beyond the size unkept parts go first, even newer ones."""
    parts = [part("fault", 3, kept="fault"), part("old", 2), part("new", 1)]
    verdict = retain(parts, now_s=NOW_S, max_bytes=20, keep_days=7)
    assert verdict.gone == ("old",)
    verdict = retain(parts, now_s=NOW_S, max_bytes=5, keep_days=7)
    assert verdict.gone == ("old", "new", "fault")


def test_only_the_host_keeps_for_longer_than_the_days() -> None:
    """Parts expire after the days that people were promised unless the host keeps them."""
    parts = [part(by, 8, kept=by) for by in ("host", "operator", "fault")]
    verdict = retain(parts, now_s=NOW_S, max_bytes=100, keep_days=7)
    assert verdict.gone == ("operator", "fault")
    assert verdict.left_bytes == 10
