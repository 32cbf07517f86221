"""The direct connection to DDS, alone on its topic."""

from __future__ import annotations

import os
import signal
import time

import pytest
from tests.robot.ros2.base import Base, own_domain

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL
from wax.robot.ros2.open_link import open_link
from wax.robot.ros2.settings import Ros2Settings

pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')


def on_this_machine(domain: int) -> Ros2Settings:
    return Ros2Settings.model_validate({"domain": domain, "interface": "127.0.0.1"})


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
