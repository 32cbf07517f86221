"""The direct connection to DDS, alone on its topic."""

from __future__ import annotations

import os
import signal
import time
from typing import Any

import pytest
from tests.robot.ros2.base import Base, own_domain

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.ros2.open_link import open_link
from wax.robot.ros2.settings import Ros2Settings

pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')


SIDEWAYS = Twist(0.25, -0.5, 0.125)


def on_this_machine(domain: int, **own: Any) -> Ros2Settings:
    return Ros2Settings.model_validate({"domain": domain, "interface": "127.0.0.1"} | own)


def test_listening_to_no_topic_takes_no_processor() -> None:
    """Without subscriptions, as by default, `take` still waits."""
    link = open_link(on_this_machine(own_domain()), SystemClock(), mark="wax")
    try:
        since_s = time.monotonic()
        assert link.take(0.05) == []
        assert time.monotonic() - since_s >= 0.05
    finally:
        link.close()


@pytest.mark.system
@pytest.mark.parametrize("kind", ["twist", "stamped"])
def test_each_speed_is_in_its_own_member(kind: str) -> None:
    """Ahead is linear.x, sideways linear.y, turning angular.z, and all others are zero."""
    domain = own_domain()
    base = Base(domain, kind=kind).start()
    link = open_link(on_this_machine(domain, stamped=kind == "stamped"), SystemClock(), mark="wax")
    try:
        base.until(lambda: link.traffic().matched, 20.0)
        link.send(SIDEWAYS, 0)
        base.until(base.told)
        assert {(told.twist, told.others) for told in base.told()} == {(SIDEWAYS, 0.0)}
    finally:
        link.close()
        base.end()


@pytest.mark.system
def test_it_closes_without_an_acknowledgement() -> None:
    """Closing does not wait for a frozen base."""
    domain = own_domain()
    base = Base(domain).start()
    assert base._process is not None
    link = open_link(on_this_machine(domain), SystemClock(), mark="wax")
    try:
        base.until(lambda: link.traffic().matched, 20.0)
        os.kill(base._process.pid, signal.SIGSTOP)
        link.send(STANDSTILL, 0)
    finally:
        link.close()
        os.kill(base._process.pid, signal.SIGCONT)
        base.end()
