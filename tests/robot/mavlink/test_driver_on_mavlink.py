"""Driving a rover on another MAVLink library, with its own failsafe."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import statistics
import threading
import time
import tty
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
from tests.free_port import free_port
from tests.robot.mavlink.conftest import drive, feed, problem, ready, settings, until
from tests.robot.mavlink.counterpart import wall_s

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver, make_robot
from wax.robot.mavlink.codec import Codec

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tests.robot.mavlink.conftest import Rig
    from tests.robot.mavlink.counterpart import Rover

pytestmark = [
    pytest.mark.system,
    pytest.mark.full,
    pytest.mark.timeout(300),
]  # the first test builds the rover

KEY = bytes(range(32))
AHEAD_LEFT = Twist(0.3, 0.5)


def stands(rover: Rover, for_s: float = 0.5) -> bool:
    """Return whether no motion reaches the rover for `for_s`."""
    rover.new_setpoints()
    time.sleep(for_s)
    return all(twist.is_zero for twist in rover.new_setpoints())


def test_its_state_comes_from_the_rover(rig: Rig) -> None:
    """Motion, position, battery, mode and the failsafe's time come from the rover itself."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    until(driver, lambda state: state.moving is False and state.pose is not None)
    drive(driver, rover)

    def is_on_its_way() -> bool:
        feed(driver, AHEAD_LEFT, 0.02)
        pose = driver.state().pose
        return pose is not None and pose.x_m > 0.1 and pose.y_m > 0.0 and pose.heading_rad > 0.2

    rover.until(is_on_its_way, "is on its way")
    state = driver.state()
    assert state.moving
    assert state.battery_v == pytest.approx(8.1)
    assert state.battery_fraction == pytest.approx(0.62)
    assert (state.extra["mode"], state.extra["armed"], state.extra["failsafe_s"]) == (
        15.0,
        1.0,
        1.0,
    )
    driver.stop(1)
    until(driver, lambda state: state.moving is False)


def test_a_rover_that_is_pushed_moves(rig: Rig) -> None:
    """A rover that moves without a command is reported as moving, by its own speed."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    rover.command("push 0.4")
    until(driver, lambda state: state.moving is True)


@pytest.mark.parametrize("mode", ["guided", "manual", "acro"])
def test_left_is_left_and_ahead_is_ahead(rig: Rig, mode: str) -> None:
    """In each mode the rover drives as commanded, by the message that the mode obeys."""
    rover, driver = rig.rover(mode=mode), rig.driver(mode=mode)
    ready(driver)
    driver.apply(STANDSTILL, 1)
    told: list[Twist] = []

    def is_told_to_move() -> bool:
        feed(driver, AHEAD_LEFT, 0.02)
        told.extend(twist for twist in rover.new_setpoints() if not twist.is_zero)
        return bool(told)

    rover.until(is_told_to_move, "is told to move")
    assert told[-1].linear_mps == pytest.approx(0.3, 0.01)
    assert told[-1].angular_rps == pytest.approx(0.5, 0.01)
    kinds = {event["event"] for event in rover.events("velocity", "manual")}
    assert kinds == {"velocity" if mode == "guided" else "manual"}


@pytest.mark.parametrize(
    ("change", "undo", "code"),
    [
        ("mode 10", "mode 15", "mavlink.wrong_mode"),
        ("mode 4", "mode 15", "mavlink.wrong_mode"),
        ("disarm", "arm", "mavlink.disarmed"),
    ],
)
def test_a_rover_in_the_wrong_state_is_left_alone(
    rig: Rig, change: str, undo: str, code: str
) -> None:
    """In another mode or disarmed nothing moves it, nor does a held input afterwards."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    drive(driver, rover)
    rover.command(change)
    sentence = problem(driver, code)
    assert sentence.endswith(("switch it to GUIDED.", "arm it."))
    feed(driver, AHEAD_LEFT, 0.3)
    assert stands(rover)
    rover.command(undo)
    ready(driver)
    rover.new_setpoints()
    feed(driver, AHEAD_LEFT, 0.5)
    assert all(twist.is_zero for twist in rover.new_setpoints())
    drive(driver, rover)


def test_in_another_mode_the_line_is_left_to_others(rig: Rig) -> None:
    """Soon after somebody has switched its mode, the rover gets heartbeats only."""
    rover, driver = rig.rover(mode="manual"), rig.driver(mode="manual")
    ready(driver)
    rover.command("mode 4")
    problem(driver, "mavlink.wrong_mode")
    time.sleep(2.5)
    rover.new_setpoints()
    before = len(rover.events("heartbeat"))
    time.sleep(1.5)
    assert rover.new_setpoints() == []
    assert len(rover.events("heartbeat")) > before


@pytest.mark.alone
def test_a_stop_is_sent_steadily_and_then_repeated(rig: Rig) -> None:
    """Zeros come at 20 Hz or more for 1.5 s, and then at 2 Hz for ever."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    drive(driver, rover)
    driver.stop(1)
    began_s = wall_s()
    time.sleep(4.0)
    at_s = [event["t"] - began_s for event in rover.events("velocity") if event["t"] > began_s]
    steady = [0.0, *(when for when in at_s if when <= 1.5), 1.5]
    gaps = [later - sooner for sooner, later in pairwise(steady)]
    assert len(steady) > 30
    assert statistics.median(gaps) < 0.05
    slow = [when for when in at_s if when > 2.5]
    assert 2 <= len(slow) <= 8
    later = [event for event in rover.events("velocity") if event["t"] > began_s + 0.1]
    assert all(event["vx"] == event["yaw_rate"] == 0.0 for event in later)


def test_our_heartbeat_comes_once_a_second(rig: Rig) -> None:
    """The heartbeat is a ground station's, from our own system number."""
    rover, driver = rig.rover(), rig.driver(own_system=200, failsafe_s=0.0)
    problem(driver, "mavlink.not_ours")
    time.sleep(3.0)
    beats = rover.events("heartbeat")
    assert {(beat["from"], beat["type"]) for beat in beats} == {(200, 6)}
    assert 3 <= len(beats) <= 6


def test_a_rover_of_another_ground_station_is_not_driven(rig: Rig) -> None:
    """It would ignore us; the problem names its parameter, as its firmware calls it."""
    rig.rover(SYSID_MYGCS=None, MAV_GCS_SYSID=250.0)
    sentence = problem(rig.driver(), "mavlink.not_ours")
    assert "250" in sentence
    assert "MAV_GCS_SYSID" in sentence


# --- the failsafe -------------------------------------------------------------------------------


def test_a_required_failsafe_must_be_enabled(rig: Rig) -> None:
    """With failsafe_s nobody drives a rover that would drive on without us."""
    rover = rig.rover(mode="manual", FS_GCS_ENABLE=0.0)
    driver = rig.driver(mode="manual", failsafe_s=2.0)
    assert "FS_GCS_ENABLE" in problem(driver, "mavlink.no_failsafe")
    feed(driver, AHEAD_LEFT, 0.3)
    assert stands(rover)
    assert driver.limits.ttl_s == 2.0
    assert "failsafe_s" not in driver.state().extra
    assert driver.state().ttl_s == 0.0


def test_a_failsafe_that_is_too_slow_is_none(rig: Rig) -> None:
    """The problem names both times."""
    rig.rover(mode="manual", FS_GCS_TIMEOUT=5.0)
    sentence = problem(rig.driver(mode="manual", failsafe_s=2.0), "mavlink.late_failsafe")
    assert "5.5 s" in sentence
    assert "2 s" in sentence


def test_without_a_demand_the_host_is_warned(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:
    """A rover without a failsafe may be driven if the host requires none; the log warns."""
    rig.rover(mode="manual", FS_GCS_ENABLE=0.0)
    driver = rig.driver(mode="manual")
    ready(driver)
    assert driver.limits.ttl_s is None
    assert "set its FS_GCS_ENABLE to 1" in capsys.readouterr().out


@pytest.mark.alone
@pytest.mark.parametrize(("mode", "why"), [("guided", "guided timeout"), ("manual", "failsafe")])
def test_the_rover_stops_by_itself_when_the_driver_dies(rig: Rig, mode: str, why: str) -> None:
    """When the driver is killed with its process, the rover stops within its timeout."""
    rover = rig.rover(mode=mode)
    driver = make_robot(settings(url=rig.here, mode=mode, failsafe_s=2.0), SystemClock())
    driver.open()
    try:
        ready(driver)
        drive(driver, rover)
        os.kill(int(driver.state().extra["driver_pid"]), signal.SIGKILL)
        killed_s = wall_s()
        driver.close()  # and start no new process
        rover.until(lambda: not rover.drives, "stops")
        last = rover.events("moves")[-1]
        assert last["why"] == why
        assert last["t"] - killed_s < 2.3
    finally:
        driver.close()


def test_a_link_that_is_cut_one_way_stops_the_rover(rig: Rig) -> None:
    """Cut off, it stops by itself; once reconnected, a held input does not move it."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    drive(driver, rover)
    epoch = driver.state().epoch
    rover.command("deaf", "mute")
    until(driver, lambda state: not state.connected)
    feed(driver, AHEAD_LEFT, 1.0)
    rover.until(lambda: not rover.drives, "stops")
    rover.command("hear")
    end_s = time.monotonic() + 5.0
    while not (state := driver.state()).connected:
        assert time.monotonic() < end_s, state
        feed(driver, AHEAD_LEFT, 0.02)
    feed(driver, AHEAD_LEFT, 0.5)
    assert state.epoch > epoch
    assert not rover.drives


def test_a_rover_that_restarts_is_a_new_one(rig: Rig) -> None:
    """A restart shows in its uptime; failsafe and telemetry are requested again."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    until(driver, lambda state: state.moving is False and state.pose is not None)
    epoch = driver.state().epoch
    rover.command("reboot")
    until(driver, lambda state: state.epoch > epoch)
    ready(driver)
    until(driver, lambda state: state.moving is False)
    drive(driver, rover)


# --- who else is on the line --------------------------------------------------------------------


def test_only_the_configured_system_is_told(rig: Rig) -> None:
    """Of two rovers on one line the other gets nothing, and its state is ignored."""
    other, rover = rig.rover(system=2, mode="hold", armed=False), rig.rover(system=1)
    driver = rig.driver()
    ready(driver)
    drive(driver, rover)
    feed(driver, AHEAD_LEFT, 0.5)
    assert other.events("velocity", "manual", "asked", "command") == []
    assert driver.state().problem is None


def test_the_wrong_number_is_named(rig: Rig) -> None:
    """If only another system answers, the problem names it."""
    rig.rover(system=7)
    sentence = problem(rig.driver(), "mavlink.other_system")
    assert "system 7" in sentence


def test_a_second_server_with_our_number_is_noticed(rig: Rig) -> None:
    """A second ground station with our number is a problem, and the rover is stopped."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    drive(driver, rover)
    beat = Codec(255, 1, None, 0).heartbeat()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
        second.sendto(beat, ("127.0.0.1", rig.port))
        problem(driver, "mavlink.twin")
    feed(driver, AHEAD_LEFT, 0.3)
    assert stands(rover)


def test_two_servers_on_one_port_are_noticed(rig: Rig) -> None:
    """The second reports it, and the first drives on."""
    rover, first = rig.rover(), rig.driver()
    ready(first)
    assert rig.here in problem(rig.driver(), "mavlink.in_use")
    drive(first, rover)


def test_garbage_on_the_line_moves_nothing(rig: Rig) -> None:
    """Random bytes and damaged frames are counted, and the rover is driven on."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    broken = bytearray(Codec(1, 255, None, 0).heartbeat())
    broken[12] ^= 0xFF
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as noise:
        for _ in range(20):
            noise.sendto(os.urandom(300), ("127.0.0.1", rig.port))
            noise.sendto(broken, ("127.0.0.1", rig.port))
    until(driver, lambda state: state.extra["line_errors"] > 0)
    drive(driver, rover)


# --- signatures ---------------------------------------------------------------------------------


def key_file(folder: Path, key: bytes = KEY) -> str:
    path = folder / "key"
    path.write_bytes(key)
    path.chmod(0o600)
    return str(path)


def test_signed_messages_are_understood_both_ways(rig: Rig, tmp_path: Path) -> None:
    """A rover that requires signatures drives with the same key."""
    rover = rig.rover(key=KEY.hex())
    driver = rig.driver(signing_key=key_file(tmp_path))
    ready(driver)
    drive(driver, rover)
    assert driver.state().extra["line_refused"] == 0.0


def test_a_wrong_key_moves_nothing(rig: Rig, tmp_path: Path) -> None:
    """Each ignores the other, and the problem says what to do."""
    rover = rig.rover(key=KEY.hex())
    driver = rig.driver(signing_key=key_file(tmp_path, bytes(32)))
    problem(driver, "mavlink.unsigned")
    assert rover.events("velocity", "asked") == []


def test_an_unsigned_rover_is_refused_if_there_is_a_key(rig: Rig, tmp_path: Path) -> None:
    """Nobody without the key can pretend to be the rover."""
    rig.rover()
    problem(rig.driver(signing_key=key_file(tmp_path)), "mavlink.unsigned")


def test_a_rover_that_signs_needs_our_key(rig: Rig) -> None:
    """It would ignore us: a problem."""
    rig.rover(key=KEY.hex())
    until(rig.driver(), lambda state: "sign" in str(state.problem))


# --- the lines ----------------------------------------------------------------------------------


def test_a_tcp_line_is_reopened(rig: Rig) -> None:
    """A rover that returns is driven again, in a later epoch, from standstill."""
    port = free_port()
    there = f"tcpin:127.0.0.1:{port}"
    driver = rig.driver(url=f"tcp:127.0.0.1:{port}")
    assert f"Nobody listens at 127.0.0.1:{port}" in problem(driver, "mavlink.not_open")
    rover = rig.rover(address=there)
    ready(driver)
    drive(driver, rover)
    epoch = driver.state().epoch
    rover.close()
    assert "Retrying" in problem(driver, "mavlink.lost") or not driver.state().connected
    again = rig.rover(address=there)
    end_s = time.monotonic() + 10.0
    while not (state := driver.state()).connected:
        assert time.monotonic() < end_s, state
        feed(driver, AHEAD_LEFT, 0.02)
    feed(driver, AHEAD_LEFT, 0.3)
    assert state.epoch > epoch
    assert not again.drives
    drive(driver, again)


def test_a_udp_line_may_go_out_to_the_rover(rig: Rig) -> None:
    """A listening rover or router is found, even if it starts after us."""
    driver = rig.driver(url=f"udpout:127.0.0.1:{rig.port}")
    time.sleep(0.3)
    rover = rig.rover(address=f"udpin:127.0.0.1:{rig.port}")
    ready(driver)
    drive(driver, rover)


def test_a_serial_port_can_be_unplugged(rig: Rig, tmp_path: Path) -> None:
    """A telemetry radio's port is reopened when it returns, from standstill."""
    rover = rig.rover(FS_GCS_TIMEOUT=60.0)
    path = tmp_path / "radio"
    with Radio(path, rig.port):
        driver = rig.driver(url=str(path))
        ready(driver)
        drive(driver, rover)
    until(driver, lambda state: not state.connected and state.problem is not None)
    rover.until(lambda: not rover.drives, "stops")
    with Radio(path, rig.port):
        ready(driver)
        feed(driver, AHEAD_LEFT, 0.3)
        assert not rover.drives
        drive(driver, rover)
        driver.close()


class Radio:
    """A pseudo-terminal at `path` that relays UDP both ways, as a radio does."""

    def __init__(self, path: Path, port: int) -> None:
        self.path = path
        self._master, slave = os.openpty()
        tty.setraw(slave)
        path.symlink_to(os.ttyname(slave))
        self._slave = slave
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(0.05)
        self._rover: Any = None
        self._plugged = True
        os.set_blocking(self._master, False)
        self._threads = [
            threading.Thread(target=work, daemon=True) for work in (self._receive, self._send)
        ]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> None:
        """Leave it plugged in."""

    def __exit__(self, *_: object) -> None:
        """Unplug it."""
        self._plugged = False
        for thread in self._threads:
            thread.join()
        self.path.unlink()
        os.close(self._slave)
        os.close(self._master)
        self._socket.close()

    def _receive(self) -> None:
        while self._plugged:
            try:
                data, self._rover = self._socket.recvfrom(4096)
            except TimeoutError:
                continue
            with contextlib.suppress(BlockingIOError):  # nobody reads
                os.write(self._master, data)

    def _send(self) -> None:
        while self._plugged:
            try:
                data = os.read(self._master, 4096)
            except BlockingIOError:
                time.sleep(0.001)
                continue
            if self._rover is not None:
                self._socket.sendto(data, self._rover)


# --- speed --------------------------------------------------------------------------------------


@pytest.mark.alone
def test_a_set_point_is_on_the_wire_at_once(
    rig: Rig, record_property: Callable[[str, object], None]
) -> None:
    """The median from the call to the rover's motion is less than 25 ms."""
    rover, driver = rig.rover(), rig.driver()
    ready(driver)
    took_ms = []
    for number in range(100):
        driver.apply(STANDSTILL, 1)
        rover.until(lambda: not rover.drives, "stands")
        time.sleep(0.03)
        before = len(rover.events("moves"))
        told_s = wall_s()
        driver.apply(Twist(0.1 + number / 1000, 0.0), 1)
        rover.until(lambda before=before: len(rover.events("moves")) > before, "moves")  # type: ignore[misc]
        took_ms.append((rover.events("moves")[before]["t"] - told_s) * 1000)
    took_ms.sort()
    record_property("set_point_to_rover_ms", {"p50": took_ms[50], "p99": took_ms[98]})
    assert took_ms[50] < 25.0


def test_kind_and_limits_before_it_is_opened(rig: Rig) -> None:
    """Kind and limits come from the configuration alone."""
    driver = make_driver(settings(url=rig.here, failsafe_s=3.0), SystemClock())
    assert (driver.kind, driver.limits.axes, driver.limits.ttl_s) == ("mavlink", (), 3.0)
