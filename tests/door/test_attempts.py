"""When the tunnel is tried again, and by which way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.door import ssh
from wax.door.attempts import HOPELESS_S, LONGEST_S, STABLE_S, Attempts

if TYPE_CHECKING:
    from wax.door.ssh import Way


def ways(attempts: Attempts, times: int) -> list[Way]:
    found = []
    for _ in range(times):
        found.append(attempts.way)
        attempts.ended("closed", 0.0)
    return found


def test_443_is_tried_where_22_is_closed() -> None:
    """The ways alternate until one works; then the other is tried only now and then."""
    attempts = Attempts()
    assert ways(attempts, 3) == ["ssh", "https", "ssh"]
    attempts.opened()
    attempts.ended("stalled", STABLE_S)
    assert ways(attempts, 9).count("https") == 7
    assert attempts.way == "https"


def test_whoever_waits_for_the_door_waits_five_seconds_at_most() -> None:
    """The longest pause and an attempt that began just too early take 5 s at most."""
    attempts = Attempts()
    pauses = [attempts.ended("closed", 0.0) for _ in range(50)]
    assert pauses == sorted(pauses)
    assert pauses[-1] == LONGEST_S
    assert LONGEST_S + ssh.CONNECT_S <= 5


@pytest.mark.parametrize("code", ["host_key", "no_user"])
def test_what_only_the_host_can_mend_is_not_tried_all_the_time(code: str) -> None:
    """A failure that only the host can fix is retried every 10 s, not every second."""
    assert Attempts().ended(code, 0.0) == HOPELESS_S


def test_a_second_robot_with_the_same_line_leaves_the_first_its_place() -> None:
    """The robot that had the port retries every second, a second robot every 10 s."""
    attempts = Attempts()
    pauses = [attempts.ended("taken", 0.0) for _ in range(30)]
    own_last_s = ssh.ALIVE_S * (ssh.ALIVE_COUNT + 1)  # the door's timeout equals ssh's
    assert sum(one for one in pauses if one <= LONGEST_S) > own_last_s
    assert pauses[-1] == HOPELESS_S
    attempts.ended("closed", 0.0)
    assert attempts.ended("taken", 0.0) == LONGEST_S


def test_after_a_good_one_the_next_follows_at_once() -> None:
    """A tunnel that worked is reopened the same way, within half a second."""
    attempts = Attempts()
    attempts.opened()
    ways(attempts, 2)
    assert attempts.ended("stalled", STABLE_S) < 0.5
    assert attempts.way == "ssh"


def test_a_stalled_tunnel_is_noticed_in_time() -> None:
    """The keepalives notice a stall within 10 s: ssh ends at the one after the last allowed."""
    assert ssh.ALIVE_S * (ssh.ALIVE_COUNT + 1) <= 10
