"""Whose offer is answered next: whoever comes after a flood is not behind it."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st
from tests.examples import examples

from wax.rate_limits import TokenBucket
from wax.session.newcomers import Newcomers


@examples(20)
@given(
    addresses=st.integers(1, 600),
    rate_hz=st.integers(5, 200),
    later_s=st.floats(0.5, 5.0),
    again_s=st.floats(1.0, 1.4),
    are_new=st.booleans(),
)
@example(addresses=50, rate_hz=135, later_s=4.5, again_s=1.0625, are_new=False)
def test_a_newcomer_gets_an_answer_whatever_others_do(
    addresses: int, rate_hz: int, later_s: float, again_s: float, are_new: bool
) -> None:
    """A page that asks again as told is answered by its third request, once others have asked."""
    newcomers, answers = Newcomers(), TokenBucket(8.0, 8)

    def asks(address: str, now_s: float) -> bool:
        has_turn = newcomers.has_turn(address, int(answers.level(now_s)), now_s)
        return has_turn and answers.take(now_s)

    came_s = addresses / rate_hz + later_s
    asked = 0
    for step in range(int((came_s + 3.0) * rate_hz) + 1):
        now_s, other = step / rate_hz, step if are_new else step % addresses
        asks(f"10.{other // 250}.{other % 250}.1", now_s)
        if now_s >= came_s + asked * again_s:
            asked += 1
            if asks("192.0.2.1", now_s):
                break
    else:
        raise AssertionError("it was not answered")
    assert asked <= 3


def test_a_page_on_a_slow_link_keeps_its_rank() -> None:
    """Whoever asks again after three seconds has waited longer than all who came since."""
    newcomers = Newcomers()
    for step in range(300):
        if step % 30 == 0:
            assert not newcomers.has_turn("192.0.2.1", 0, step / 10)
        assert not newcomers.has_turn(f"10.{step // 250}.{step % 250}.1", 0, step / 10)
    assert newcomers.has_turn("192.0.2.1", 1, 30.0)


def test_whoever_gave_up_is_new_after_a_minute() -> None:
    """An address that asked once, long ago, gets the answers that are for whoever came last."""
    newcomers = Newcomers()
    assert not newcomers.has_turn("192.0.2.1", 0, 0.0)
    for step in range(1, 62):
        assert not newcomers.has_turn("10.0.1.1", 0, float(step))
        assert not newcomers.has_turn("10.0.2.1", 0, float(step))
    assert not newcomers.has_turn("192.0.2.1", 1, 61.5)
    assert newcomers.has_turn("10.0.1.1", 1, 61.5)
    assert newcomers.has_turn("192.0.2.1", 1, 61.6)


def test_whoever_waits_longest_and_whoever_came_last_take_turns() -> None:
    """Whoever has waited and whoever is new get every other answer, and the others none."""
    newcomers = Newcomers()
    for number, address in enumerate(("1.0.0.1", "2.0.0.1", "3.0.0.1", "4.0.0.1")):
        assert not newcomers.has_turn(address, 0, number / 10)
    assert not newcomers.has_turn("2.0.0.1", 1, 0.5)
    assert newcomers.has_turn("1.0.0.1", 1, 0.5)
    assert not newcomers.has_turn("2.0.0.1", 1, 0.6)
    assert newcomers.has_turn("4.0.0.1", 1, 0.6)
    assert newcomers.has_turn("2.0.0.1", 1, 0.7)


def test_a_network_takes_turns_with_others() -> None:
    """However many addresses one sender has, somebody of another network is next but one."""
    newcomers = Newcomers()
    for number in range(100):
        assert not newcomers.has_turn(f"2001:db8:1:{number:x}::/64", 0, 0.0)
    assert not newcomers.has_turn("2001:db8:2::/64", 1, 0.1)
    assert newcomers.has_turn("2001:db8:2::/64", 2, 0.2)


def test_an_unused_answer_is_for_others() -> None:
    """Those who do not come for theirs keep nobody waiting for long."""
    newcomers = Newcomers()
    for number in range(100):
        assert not newcomers.has_turn(f"10.0.{number}.1", 0, 0.0)
    assert not newcomers.has_turn("192.0.2.1", 1, 0.1)
    assert newcomers.has_turn("192.0.2.1", 1, 1.6)


def test_an_answer_is_kept_until_its_owner_asks() -> None:
    """Others take what is beyond it, so that it does not matter when its owner asks."""
    newcomers = Newcomers()
    for number in range(10):
        assert not newcomers.has_turn(f"10.0.{number}.1", 0, number / 10)
    assert newcomers.has_turn("10.0.8.1", 4, 1.1)
    assert not newcomers.has_turn("10.0.7.1", 3, 1.1)
    assert newcomers.has_turn("10.0.1.1", 3, 1.1)
    assert not newcomers.has_turn("10.0.2.1", 2, 1.1)
    assert newcomers.has_turn("10.0.9.1", 2, 1.2)
    assert newcomers.has_turn("10.0.0.1", 1, 1.2)


def test_whoever_was_let_in_comes_back_as_new() -> None:
    """A browser at an address from which somebody joined before is as new as others."""
    newcomers = Newcomers()
    assert newcomers.has_turn("192.0.2.1", 1, 0.0)
    assert not newcomers.has_turn("10.0.0.1", 0, 1.0)
    newcomers.forget("192.0.2.1")
    assert newcomers.has_turn("192.0.2.1", 1, 1.1)
