"""Sender-side control: when a picture may leave, and what is retransmitted."""

from __future__ import annotations

import pytest

from wax.congestion.control import Delivery
from wax.congestion.sender_side import SenderSideControl
from wax.congestion.upload_budget import UploadBudget

KBIT = 1000 / 8


class Line:
    """Sends over a link of one rate, 20 ms each way, and reports what arrived."""

    def __init__(self, rate_bps: float) -> None:
        self.rate_bps = rate_bps
        self.looks = 0
        self.control = SenderSideControl(self._looked)
        self.now_s = 100.0
        self.sent_bytes = 0
        self._free_s = 0.0
        self._told: list[tuple[float, Delivery]] = []

    def _looked(self, _estimate: object, _now_s: float) -> None:
        self.looks += 1

    def packet(self, size: int, *, train: int | None = None) -> None:
        self.control.sent(size, self.now_s, is_media=True)
        self.sent_bytes += size
        self._free_s = max(self._free_s, self.now_s) + size * 8 / self.rate_bps
        kind = "audio" if train is None else "video"
        delivery = Delivery(self.now_s, 7000 + self._free_s + 0.02, size, kind, train)  # type: ignore[arg-type]
        self._told.append((self._free_s + 0.04, delivery))

    def run(self, seconds: float, picture_bytes: int) -> int:
        """Send sound each 20 ms and pictures of this size whenever the link is free."""
        pictures = 0
        for tick in range(round(seconds * 500)):
            self.now_s += 0.002
            due = [one for at_s, one in self._told if at_s <= self.now_s]
            self._told = [one for one in self._told if one[0] > self.now_s]
            if due:
                self.control.delivered(due, self.now_s)
            if tick % 10 == 0:
                self.packet(120)
            if tick % 16 == 0 and self.control.free_in_s(None, self.now_s) <= 0.001:
                pictures += 1
                train = self.control.plan_train(picture_bytes, self.now_s)
                left = picture_bytes
                while left > 0:
                    self.packet(min(left, train.payload_bytes) + 62, train=train.number)
                    left -= train.payload_bytes
        return pictures


def test_files_take_a_quarter_of_a_free_link() -> None:
    """Several files share it; behind a queue they wait until it is gone, but 5 s at most."""
    line = Line(40e3)
    line.run(5.0, 400)
    line.now_s += 10.0
    rate_bps = line.control._pacer.rate_bps
    took_s = 8 * 252 / (0.25 * rate_bps)
    waits_s = [line.control.file_sent(200, line.now_s) for _ in range(3)]
    assert waits_s == pytest.approx([took_s, 2 * took_s, 3 * took_s])
    line.control.sent(10_000, line.now_s, is_media=False)
    assert line.control.file_sent(200, line.now_s) >= 8 * 10_000 / rate_bps
    assert [line.control.file_sent(200, line.now_s) for _ in range(100)][-1] == 5.0


def test_a_fast_link_lets_every_picture_go() -> None:
    """Over a link with room no picture waits."""
    line = Line(20e6)
    line.run(2.0, 4000)
    assert line.run(2.0, 4000) >= 58


def test_a_slow_link_lets_as_many_go_as_it_carries() -> None:
    """Over a thin link pictures wait for the pacer, and the queue stays short."""
    line = Line(200e3)
    line.run(8.0, 1000)
    carried = line.run(8.0, 1000)
    assert 40 <= carried <= 180  # of 250; 200 kbit/s minus the sound are 19 a second
    assert line.control.estimate(line.now_s).queue_ms < 150
    assert line.looks > 80


def test_what_is_stuck_stops_pictures_but_for_a_try() -> None:
    """While feedback is missing, three pictures a second are sent instead of thirty."""
    line = Line(20e6)
    line.control.full_feedback = True
    line.run(3.0, 4000)
    gone = 0
    for _ in range(500):
        line.now_s += 0.002
        line.control.sent(120, line.now_s, is_media=True)
        if line.control.free_in_s(1.0, line.now_s) <= 0.001:
            line.control.plan_train(4000, line.now_s)
            gone += 1
    assert 2 <= gone <= 4


def test_another_link_is_found_out_anew() -> None:
    """After a change of link nothing known of the old one counts."""
    line = Line(200e3)
    line.control.negotiated(has_feedback=True)
    line.run(4.0, 1000)
    for _ in range(1000):
        line.now_s += 0.002
        line.control.sent(120, line.now_s, is_media=True)
    assert line.control.estimate(line.now_s).state == "blind"
    line.control.reset()
    assert line.control.estimate(line.now_s).state == "starting"
    assert line.control.free_in_s(None, line.now_s) == 0.0
    line.rate_bps = 20e6
    line._free_s, line._told = 0.0, []
    line.run(2.0, 4000)
    assert line.run(2.0, 4000) >= 58


def test_another_links_first_picture_waits_for_nothing() -> None:
    """What was lost in between is repeated first, and would take long at the assumed rate."""
    line = Line(20e6)
    line.run(2.0, 1000)
    line.control.reset()
    for _ in range(20):
        line.packet(1000)
    assert line.control.free_in_s(None, line.now_s) == 0.0
    line.control.plan_train(500, line.now_s)
    assert line.control.free_in_s(None, line.now_s) > 0.5


def test_another_link_has_the_feedback_that_was_agreed() -> None:
    """On the new link a browser without feedback is not waited for either."""
    control = SenderSideControl(lambda _estimate, _now_s: None)
    control.negotiated(has_feedback=False, kind="audio")
    control.negotiated(has_feedback=False)
    control.reset()
    for tick in range(500):
        control.sent(1000, 100 + tick / 100, is_media=True, has_feedback=False)
    assert control.estimate(105).state != "blind"
    assert control.estimate(105) == _without_feedback().estimate(105)


def _without_feedback() -> SenderSideControl:
    control = SenderSideControl(lambda _estimate, _now_s: None)
    control.negotiated(has_feedback=False, kind="audio")
    control.negotiated(has_feedback=False)
    for tick in range(500):
        control.sent(1000, 100 + tick / 100, is_media=True, has_feedback=False)
    return control


def test_what_others_take_is_counted() -> None:
    """Data channels and their acknowledgements are counted apart from sound and picture."""
    control = SenderSideControl(lambda _estimate, _now_s: None)
    for tick in range(400):
        control.sent(100, 100 + tick / 20, is_media=False)
        control.sent(1000, 100 + tick / 20, is_media=True)
    assert 12_000 < control.other_bps < 20_000  # 20 a second of 800 bit


def _repeated(line: Line, first_bytes: int) -> int:
    """Ask 1000 times in a second, each after sending so much first; return the bytes granted."""
    granted = 0
    for _ in range(1000):
        line.now_s += 0.001
        line.control.sent(first_bytes, line.now_s, is_media=True, has_feedback=False)
        if line.control.may_retransmit(1000, 0.05, line.now_s):
            line.control.sent(1000, line.now_s, is_media=True, has_feedback=False)
            granted += 1000
    return granted


def test_repeats_are_a_share_of_the_rate_and_have_a_deadline() -> None:
    """Retransmissions take at most a quarter of the rate, and none is sent that would be late."""
    line = Line(1e6)
    line.run(3.0, 3000)
    rate_bps = line.control.estimate(line.now_s).rate_bps
    assert 0.15 * rate_bps < 8 * _repeated(line, 100) < 0.6 * rate_bps
    assert not line.control.may_retransmit(100, 3.0, line.now_s + 60)


def test_repeats_are_a_share_of_what_was_sent_first() -> None:
    """Even on a fast link, requesting everything again costs only a quarter more."""
    line = Line(20e6)
    line.run(3.0, 1000)
    at_once = _repeated(line, 100)
    assert at_once <= 0.25 * (line.sent_bytes + 100_000) + 2000, "nobody is owed a burst"
    assert 0.2 * 100_000 < _repeated(line, 100) <= 0.25 * 100_000 + 2000
    line.now_s += 10.0
    assert _repeated(line, 0) < 100_000, "ten seconds of silence earn nothing"


def test_repeats_need_room_in_the_upload_of_all() -> None:
    """All retransmissions together take a twentieth of the upload; the operator's are exempt."""
    budget = UploadBudget(1e6)
    line = Line(20e6)
    line.control = SenderSideControl(lambda _estimate, _now_s: None, budget)
    line.run(3.0, 3000)
    _repeated(line, 400)
    assert 0.9 * 50_000 < 8 * _repeated(line, 400) < 1.2 * 50_000
    line.control.full_feedback = True
    assert 8 * _repeated(line, 400) > 200_000


def test_a_full_link_gets_no_retransmissions() -> None:
    """Behind a standing queue nothing is retransmitted, because that would lengthen it."""
    line = Line(5e6)
    line.run(3.0, 4000)
    assert line.control.may_retransmit(100, 0.05, line.now_s)
    line.rate_bps = 100e3
    for _ in range(40):
        line.packet(1200, train=line.control.plan_train(1200, line.now_s).number)
    line.run(0.6, 1000)
    assert not line.control.may_retransmit(100, 0.05, line.now_s)


def test_a_browser_that_tells_of_no_arrivals_is_served_by_its_losses() -> None:
    """Without transport-wide feedback on either stream the rate follows the losses."""
    control = SenderSideControl(lambda _estimate, _now_s: None)
    control.negotiated(has_feedback=False)
    before = control.estimate(100.0)
    assert (before.state, before.assumed) == ("steady", False)
    control.lost(0.5, 101.0)
    after = control.estimate(101.0)
    assert after.rate_bps < 0.8 * before.rate_bps
    assert after.lost == 0.5
    assert control.plan_train(4000, 101.0).pace_bps == after.rate_bps
    control.negotiated(has_feedback=True)
    control.lost(0.5, 102.0)
    assert control.estimate(102.0).assumed
