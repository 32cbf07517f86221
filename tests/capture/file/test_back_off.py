"""A failing address is tried ever more rarely, a working one at once."""

from __future__ import annotations

from wax.capture.file.back_off import BackOff


def test_pauses_double_up_to_a_quarter_of_a_minute() -> None:
    """The pauses are 1, 2, 4, 8, 15, 15 … seconds without end."""
    back_off = BackOff()
    pauses = []
    for _ in range(2000):
        back_off.failed(100.0, delivered=False, refused=False)
        pauses.append(back_off.until_s - 100.0)
    assert pauses[:6] == [1, 2, 4, 8, 15, 15]
    assert set(pauses[6:]) == {15.0}


def test_what_has_delivered_is_opened_at_once() -> None:
    """A stream that broke off is reopened at once, and later failures start over at 1 s."""
    back_off = BackOff()
    for _ in range(5):
        back_off.failed(100.0, delivered=False, refused=False)
    back_off.failed(100.0, delivered=True, refused=False)
    assert back_off.until_s == 100.0
    back_off.failed(101.0, delivered=False, refused=False)
    assert back_off.until_s == 102.0


def test_a_wrong_password_waits_longest() -> None:
    """A wrong password pauses for long enough that no camera locks its users out."""
    back_off = BackOff()
    back_off.failed(0.0, delivered=False, refused=True)
    assert back_off.until_s == 30.0
