"""The estimated delay of the operator's link."""

from __future__ import annotations

from tests.control.rules import RULES

from wax.control.operator_delay import OperatorDelay


class Meter:
    """A fake measurement that records whose link was measured."""

    def __init__(self, one_way_s: float | None) -> None:
        self.one_way_s = one_way_s
        self.asked: list[int] = []

    def measure(self, viewer: int) -> float | None:
        self.asked.append(viewer)
        return self.one_way_s


def test_what_grows_is_not_allowed() -> None:
    """The delay is measured until known; later growth gives no further allowance."""
    meter = Meter(None)
    line = OperatorDelay(meter.measure, RULES)
    assert line.one_way_s(7) is None
    meter.one_way_s = 0.1
    assert line.one_way_s(7) == 0.1
    meter.one_way_s = 0.9
    assert line.one_way_s(7) == 0.1


def test_the_least_counts() -> None:
    """An estimate made on a busy link falls when the link is idle, and does not rise again."""
    meter = Meter(0.1)
    line = OperatorDelay(meter.measure, RULES)
    assert line.one_way_s(7) == 0.1
    meter.one_way_s = 0.02
    assert line.one_way_s(7) == 0.02
    meter.one_way_s = 0.1
    assert line.one_way_s(7) == 0.02
    meter.one_way_s = None
    assert line.one_way_s(7) == 0.02
    meter.one_way_s = 0.0
    assert line.one_way_s(7) == 0.0
    meter.one_way_s = 0.1
    assert line.one_way_s(7) == 0.0


def test_nobodys_line_is_not_measured() -> None:
    """Without an operator no link is measured."""
    meter = Meter(0.1)
    assert OperatorDelay(meter.measure, RULES).one_way_s(None) is None
    assert meter.asked == []


def test_another_connection_is_measured_anew() -> None:
    """The next operator gets no allowance from the last one's link."""
    meter = Meter(0.1)
    line = OperatorDelay(meter.measure, RULES)
    assert line.one_way_s(7) == 0.1
    line.begin()
    meter.one_way_s = None
    assert line.one_way_s(8) is None
    meter.one_way_s = 0.2
    assert line.one_way_s(8) == 0.2


def test_a_turn_that_renews_is_measured_anew() -> None:
    """A renewed turn uses the present delay, or the old one if there is none."""
    meter = Meter(0.1)
    line = OperatorDelay(meter.measure, RULES)
    assert line.one_way_s(7) == 0.1
    meter.one_way_s = 0.2
    line.renew(7)
    assert line.one_way_s(7) == 0.2
    meter.one_way_s = None
    line.renew(7)
    assert line.one_way_s(7) == 0.2


def test_one_late_answer_costs_nobody_their_turn() -> None:
    """A delay too long to drive with is measured again until it is short enough."""
    meter = Meter(0.36)
    line = OperatorDelay(meter.measure, RULES)
    assert line.one_way_s(7) == 0.36
    meter.one_way_s = None
    assert line.one_way_s(7) == 0.36
    meter.one_way_s = 0.3
    assert line.one_way_s(7) == 0.3
    meter.one_way_s = 0.34
    assert line.one_way_s(7) == 0.3
