"""The connection straight into DDS, alone on its topic."""

from __future__ import annotations

import time

import pytest
from tests.robot.ros2.base import own_domain

from wax.clock import SystemClock
from wax.robot.ros2.open_link import open_link
from wax.robot.ros2.settings import Ros2Settings

pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')


def test_listening_to_no_topic_takes_no_processor() -> None:
    """Where nothing is subscribed to, as with the defaults, whoever listens waits all the same."""
    tree = {"domain": own_domain(), "interface": "127.0.0.1"}
    settings = Ros2Settings.model_validate(tree)
    link = open_link(settings, SystemClock(), mark="wax")
    try:
        since_s = time.monotonic()
        assert link.take(0.05) == []
        assert time.monotonic() - since_s >= 0.05
    finally:
        link.close()
