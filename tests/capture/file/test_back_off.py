"""An address in vain is tried ever more seldom, and one that worked at once."""

from __future__ import annotations

from wax.capture.file.back_off import BackOff


def test_pauses_double_up_to_a_quarter_of_a_minute() -> None:
    """1, 2, 4, 8, 15, 15 … seconds, for ever."""
    back_off = BackOff()
    pauses = []
    for _ in range(2000):
        back_off.failed(100.0, delivered=False, refused=False)
        pauses.append(back_off.until_s - 100.0)
    assert pauses[:6] == [1, 2, 4, 8, 15, 15]
    assert set(pauses[6:]) == {15.0}


def test_what_has_delivered_is_opened_at_once() -> None:
    """A stream that broke off is no stranger, and what fails after it begins anew."""
    back_off = BackOff()
    for _ in range(5):
        back_off.failed(100.0, delivered=False, refused=False)
    back_off.failed(100.0, delivered=True, refused=False)
    assert back_off.until_s == 100.0
    back_off.failed(101.0, delivered=False, refused=False)
    assert back_off.until_s == 102.0


def test_a_wrong_password_waits_longest() -> None:
    """Nobody is locked out for us."""
    back_off = BackOff()
    back_off.failed(0.0, delivered=False, refused=True)
    assert back_off.until_s == 30.0
