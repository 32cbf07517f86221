"""The connection's two threads survive whatever a link raises."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import pytest
from tests.robot.ros2.robots import feed, ros2_settings, until

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver
from wax.robot.ros2 import session
from wax.robot.ros2.command_topic import Endpoint, Traffic
from wax.robot.ros2.standby_rules import SILENCE_S

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.driver.interface import Driver

AHEAD = Twist(0.3, 0.0)
REOPEN_S = 0.1


class FakeLink:
    """A `Link` to one base in this process; the method named in `failing` always raises."""

    guid = "me"

    def __init__(self) -> None:
        self.failing = ""
        self.opened = 0
        self.is_closed = False
        self.looks = 0
        self.subscribers = ["base"]
        self.timeout_s: float | None = None
        self.told: list[Twist] = []

    def open(self, *_: Any, **__: Any) -> FakeLink:
        self.opened += 1
        self.is_closed = False
        self._fail("open")
        return self

    def send(self, twist: Twist, _: int) -> None:
        self._fail("send")
        self.told.append(twist)

    def take(self, timeout_s: float) -> list[tuple[str, Any]]:
        time.sleep(timeout_s / 10)
        self._fail("take")
        return []

    def traffic(self) -> Traffic:
        self.looks += 1
        self._fail("traffic")
        subscribers = tuple(Endpoint(guid, "geometry_msgs/Twist") for guid in self.subscribers)
        return Traffic(subscribers, (), len(subscribers), self.timeout_s)

    def close(self) -> None:
        self.is_closed = True
        self._fail("close")

    def _fail(self, name: str) -> None:
        if self.failing == name:
            raise RuntimeError(name)


class FakeStandby:
    """A standby for `link`; `speaks` makes the driver find that it has sent standstill.

    `freezes` makes the driver freeze just before a motion.
    """

    guid = "standby"
    guids = frozenset({guid})
    is_ready = True

    def __init__(self, link: FakeLink) -> None:
        self._link = link
        self.speaks = self.freezes = False
        self.told: list[tuple[bool, int]] = []
        self.told_before: int | None = None
        self.found_closed: list[bool] = []

    @property
    def speaks_at_s(self) -> float:
        if not self.speaks:
            return math.inf
        self.speaks = False
        self.told_before = len(self._link.told)
        return 0.0

    def poll(self) -> None:
        """Report no problem."""

    def report(self, *, owes: bool) -> None:
        self.told.append((owes, len(self._link.told)))
        if self.freezes and owes:
            self.freezes = False
            self.told_before = len(self._link.told)
            time.sleep(SILENCE_S)

    def leave(self) -> None:
        self.found_closed.append(self._link.is_closed)


@pytest.fixture
def link(monkeypatch: pytest.MonkeyPatch) -> FakeLink:
    link = FakeLink()
    monkeypatch.setattr(session, "open_link", link.open)
    return link


@pytest.fixture
def standby(link: FakeLink, monkeypatch: pytest.MonkeyPatch) -> FakeStandby:
    standby = FakeStandby(link)
    monkeypatch.setattr(session, "StandbyProcess", lambda *_: standby)
    return standby


@pytest.fixture
def driver(standby: FakeStandby) -> Iterator[Driver]:
    settings = ros2_settings(0, transport="rosbridge", reopen_s=REOPEN_S)
    driver = make_driver(settings, SystemClock())
    driver.open()
    until(driver, lambda state: state.connected)
    yield driver
    driver.close()


def looked(driver: Driver, link: FakeLink, twist: Twist = STANDSTILL) -> None:
    """Send `twist` until the driver has checked once more who takes the commands."""
    seen = link.looks + 2  # a check may be under way
    while link.looks < seen:
        feed(driver, twist, for_s=0.02)


def moved(driver: Driver, link: FakeLink) -> None:
    """Drive from standstill until the base has received it."""
    end_s = time.monotonic() + 5.0
    while link.told[-1:] != [AHEAD]:
        assert time.monotonic() < end_s, (link.told[-5:], driver.state())
        driver.apply(STANDSTILL, 1)
        feed(driver, AHEAD, for_s=0.04)


@pytest.mark.parametrize("failing", ["send", "traffic", "take"])
def test_whatever_a_link_raises_it_is_reopened(
    driver: Driver, link: FakeLink, failing: str
) -> None:
    """If a thread fails, the robot is disconnected and the link is retried."""
    epoch = driver.state().epoch
    link.failing = failing
    until(driver, lambda state: state.said is not None and state.said.code == "robot.no_answer")
    opened, since_s = link.opened, time.monotonic()
    feed(driver, Twist(0.1), for_s=0.5)
    often = link.opened - opened
    assert often <= 1 + (time.monotonic() - since_s) / REOPEN_S
    link.failing = ""
    until(driver, lambda state: state.connected and state.epoch > epoch)


@pytest.mark.parametrize(
    "steps", [[["base 2"]], [["recorder"], ["recorder", "base 2"]]], ids=["at once", "later"]
)
def test_a_base_that_comes_back_is_a_new_connection(
    driver: Driver, link: FakeLink, steps: list[list[str]]
) -> None:
    """A held input does not move a base that has restarted, whoever else subscribes."""
    link.subscribers = ["base", "recorder"]
    looked(driver, link)
    until(driver, lambda state: state.connected)
    moved(driver, link)
    for subscribers in steps:
        epoch = driver.state().epoch
        link.subscribers = subscribers
        looked(driver, link, AHEAD)
    until(driver, lambda state: state.connected and state.epoch > epoch)
    link.told.clear()
    while len(link.told) < 3:
        feed(driver, AHEAD, for_s=0.02)
    assert all(twist.is_zero for twist in link.told)
    moved(driver, link)


def test_the_robots_timeout_is_reported_while_it_has_one(driver: Driver, link: FakeLink) -> None:
    """A timeout that is off or no longer known is not reported."""
    promises: list[float | None] = [0.5, 0.0, None]
    for link.timeout_s in promises:
        until(driver, lambda state: state.ttl_s == link.timeout_s)
        assert driver.state().connected


def test_a_timeout_of_one_of_two_subscribers_does_not_count(driver: Driver, link: FakeLink) -> None:
    """The other one may be the one that moves the wheels."""
    link.timeout_s = 0.5
    until(driver, lambda state: state.ttl_s == 0.5)
    link.subscribers = [*link.subscribers, "another"]
    until(driver, lambda state: state.connected and state.ttl_s is None)
    link.timeout_s = 0.0
    until(driver, lambda state: state.ttl_s == 0.0)


def test_a_standby_sends_last(driver: Driver, link: FakeLink, standby: FakeStandby) -> None:
    """It leaves only after the link is closed, whose last command is standstill."""
    moved(driver, link)
    driver.close()
    assert standby.found_closed == [True]
    assert link.told[-1] == STANDSTILL
    driver.apply(AHEAD, 1)
    assert link.told[-1] == STANDSTILL


def test_a_driver_without_set_points_stands(driver: Driver, link: FakeLink) -> None:
    """A set-point expires after its time to live; a stop counts at once."""
    moved(driver, link)
    until(driver, lambda _: link.told[-1] == STANDSTILL)
    moved(driver, link)
    driver.stop(1)
    until(driver, lambda _: link.told[-1] == STANDSTILL)


def test_a_standby_hears_of_a_motion_first(
    driver: Driver, link: FakeLink, standby: FakeStandby
) -> None:
    """If the driver froze in between, nobody would stop the moving robot."""
    moved(driver, link)
    first = next(number for number, twist in enumerate(link.told) if not twist.is_zero)
    assert (True, first) in standby.told


@pytest.mark.parametrize("when", ["speaks", "freezes"])
def test_what_a_standby_has_stopped_stays_stopped(
    driver: Driver, link: FakeLink, standby: FakeStandby, when: str
) -> None:
    """After the standby has sent, earlier motion is over and standstill comes first."""
    moved(driver, link)
    epoch = driver.state().epoch
    setattr(standby, when, True)
    feed(driver, AHEAD, for_s=0.1)
    until(driver, lambda state: state.connected and state.epoch > epoch)
    feed(driver, AHEAD, for_s=0.1)
    assert standby.told_before is not None
    assert set(link.told[standby.told_before :]) == {STANDSTILL}
    moved(driver, link)
