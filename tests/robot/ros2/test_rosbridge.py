"""The driver for ROS 2 with a rosbridge server written from the protocol."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
import threading
import time
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from structlog.testing import capture_logs
from tests.free_port import free_port
from tests.real_time import may_run_in_real_time
from tests.robot.ros2.bridge import Bridge
from tests.robot.ros2.robots import driven, feed, opened, ros2_settings, standing, told, until
from tests.tls_server import serving

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.errors import DriverError
from wax.robot.find_driver import make_driver, make_robot
from wax.robot.ros2 import rosbridge_protocol as protocol
from wax.robot.ros2.command_topic import OURS, judge
from wax.robot.ros2.link import Wanted
from wax.robot.ros2.names import TWIST
from wax.robot.ros2.rosbridge_graph import RosbridgeGraph
from wax.robot.ros2.rosbridge_link import RosbridgeLink
from wax.robot.ros2.settings import Ros2Settings
from wax.robot.ros2.standby_process import STARTS
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from wax.clock import Clock
    from wax.driver.interface import Driver

CURVE = Twist(0.25, -0.5)
SIDEWAYS = Twist(0.25, -0.5, 0.125)


@pytest.fixture
def bridge() -> Iterator[Bridge]:
    bridge = Bridge().start()
    yield bridge
    bridge.end()


def by_bridge(bridge: Bridge, **own: Any) -> Any:
    return ros2_settings(0, transport="rosbridge", rosbridge_url=bridge.url, **own)


@pytest.mark.system
@pytest.mark.full
@pytest.mark.timeout(120)
class TestByRosbridge(DriverSafety):
    """Observed by the server's commands."""

    @pytest.fixture(autouse=True)
    def _robot(self, bridge: Bridge) -> None:
        self.bridge = bridge

    def make_driver(self, clock: Clock) -> Driver:
        return make_driver(by_bridge(self.bridge), clock)

    def commanded(self) -> Sequence[Twist]:
        return [told.twist for told in self.bridge.forget()]

    def cut(self) -> None:
        self.bridge.end()

    def mend(self) -> None:
        self.bridge.start()


@pytest.mark.system
class TestOneServer:
    @pytest.fixture
    def driver(self, bridge: Bridge) -> Iterator[Driver]:
        driver = make_driver(by_bridge(bridge), SystemClock())
        yield driver
        driver.close()

    def test_odometry_is_subscribed_to_and_read(self, bridge: Bridge, driver: Driver) -> None:
        """It advertises its topic and subscribes, to at most 20 a second.

        A pose comes from JSON as from DDS; invalid odometry is counted.
        """
        opened(driver)
        said = {(one["op"], one.get("topic")): one for one in bridge.heard}
        assert said["advertise", "/cmd_vel"]["type"] == "geometry_msgs/msg/Twist"
        assert said["subscribe", "/odom"]["type"] == "nav_msgs/msg/Odometry"
        assert said["subscribe", "/odom"]["throttle_rate"] == 50
        bridge.say_raw("not JSON")
        bridge.say("/odom", {"pose": 7})
        message = {
            "pose": {
                "pose": {
                    "position": {"x": 1, "y": 2},
                    "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
                }
            },
            "twist": {"twist": {"linear": {"x": 0.2, "y": 0}, "angular": {"z": 0}}},
        }
        state = told(
            driver, lambda: bridge.say("/odom", message), lambda state: state.pose is not None
        )
        assert state.pose is not None
        assert (state.pose.x_m, state.pose.y_m, state.moving) == (1.0, 2.0, True)
        assert state.extra["ros2_invalid"] == 1.0

    def test_a_stop_is_sent_long_enough(self, bridge: Bridge, driver: Driver) -> None:
        """After a stop, only standstill comes, for as long as by any link.

        `test_conversation_on_ros2` checks how often and how long, on a manual clock.
        """
        driven(bridge, opened(driver), CURVE)
        at_s = time.monotonic()
        driver.stop(1)
        standing(bridge)
        bridge.forget()
        end_s = at_s + 5.0
        while not any(told.at_s > at_s + 1.4 for told in bridge.told()):
            assert time.monotonic() < end_s
            time.sleep(0.05)
        assert all(told.twist.is_zero and told.others == 0.0 for told in bridge.told())
        assert len(bridge.told()) > 3

    def test_a_second_publisher_stops_the_robot(self, bridge: Bridge, driver: Driver) -> None:
        """Another publisher that rosapi names is a problem, and the robot gets standstill."""
        driven(bridge, opened(driver), CURVE)
        bridge.publishers = ["/rosbridge_websocket", "/joystick"]
        until(
            driver,
            lambda state: state.said is not None and state.said.code == "ros2.other_publisher",
        )
        standing(bridge)
        bridge.forget()
        feed(driver, CURVE, for_s=0.3)
        assert all(told.twist.is_zero for told in bridge.told())

    def test_nobody_listens(self, bridge: Bridge, driver: Driver) -> None:
        """A server without a base is no robot."""
        bridge.subscribers = []
        driver.open()
        until(
            driver,
            lambda state: state.said is not None and state.said.code == "ros2.nobody_listens",
        )

    def test_a_server_without_rosapi_is_driven(self, bridge: Bridge, driver: Driver) -> None:
        """An unknown graph holds nobody."""
        bridge.has_rosapi = False
        driven(bridge, opened(driver), CURVE)

    def test_a_refused_request_costs_only_its_answer(self, bridge: Bridge, driver: Driver) -> None:
        """Bridges that refuse a call or a topic by a status are driven as if without rosapi."""
        bridge.has_rosapi, bridge.refuses_by_status = False, True
        opened(driver)
        lines = set(bridge.lines)
        for words in ("subscribe: unknown type", "call_service: no such service"):
            bridge.say_raw(json.dumps({"op": "status", "level": "error", "msg": words}))
        driven(bridge, driver, CURVE)
        assert lines <= bridge.lines

    def test_a_wrong_type_is_reported_in_the_servers_words(
        self, bridge: Bridge, driver: Driver
    ) -> None:
        """The server's refusal is shown in its own words, and the link is retried."""
        bridge.type_name = "geometry_msgs/msg/TwistStamped"
        driver.open()
        until(driver, lambda state: "has been established with type" in str(state.said))
        bridge.type_name = "geometry_msgs/msg/Twist"
        until(driver, lambda state: state.connected)

    def test_a_stuck_connection_is_given_up(self, bridge: Bridge, driver: Driver) -> None:
        """If the other side reads nothing, waiting commands are dropped, not delivered later."""
        driven(bridge, opened(driver), CURVE)
        line = bridge.driving
        bridge.turn_deaf(deaf=True)
        end_s = time.monotonic() + 20.0
        with capture_logs() as logs:
            while not any(log["event"] == "the robot's link is lost" for log in logs):
                assert time.monotonic() < end_s
                driver.apply(STANDSTILL, 1)  # needed after a pause of a busy machine
                feed(driver, CURVE, for_s=0.1)
        bridge.turn_deaf(deaf=False)
        # The old connection has ended once all that was sent has been read.
        until(driver, lambda state: state.connected and line not in bridge.lines)
        bridge.forget()
        feed(driver, CURVE, for_s=0.3)
        assert all(told.twist.is_zero for told in bridge.told())


@contextlib.contextmanager
def linked(
    bridge: Bridge, mark: str, *wanted: Wanted, clock: Clock | None = None
) -> Iterator[RosbridgeLink]:
    settings = by_bridge(bridge).own(Ros2Settings)
    link = RosbridgeLink(settings, clock or SystemClock(), mark=mark, wanted=wanted)
    yield link
    link.close()


def failure(link: RosbridgeLink) -> str:
    """Wait until the link fails; return its error."""
    end_s = time.monotonic() + 5.0
    while time.monotonic() < end_s:
        try:
            link.traffic()
        except DriverError as error:
            return str(error)
        time.sleep(0.005)
    raise AssertionError("it did not fail")


@pytest.mark.parametrize(
    ("answer", "scheme", "code"),
    [
        (b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", "ws", "ros2.no_websocket"),
        (b"SSH-2.0-x\r\n", "ws", "unreachable.no_http"),
        (b"", "ws", "unreachable.closed"),
        (b"", "wss", "unreachable.no_tls"),
        (None, "ws", "unreachable.nobody"),
    ],
)
def test_the_error_names_what_is_no_rosbridge_server(
    answer: bytes | None, scheme: str, code: str
) -> None:
    """Another program, another port, a wrong scheme or nobody: each has an error of its own."""
    with serving(None, answer or b"") as answered:
        port = free_port() if answer is None else answered
        settings = Ros2Settings.model_validate({"rosbridge_url": f"{scheme}://127.0.0.1:{port}"})
        with pytest.raises(DriverError) as caught:
            RosbridgeLink(settings, SystemClock())
    said = caught.value.sentence
    assert code in (said.code, getattr(said.values.get("why"), "code", None))


@pytest.mark.system
def test_its_address_is_used_as_written_and_shown_without_secrets(bridge: Bridge) -> None:
    """A server behind a proxy may need a token, which errors do not show."""
    url = f"ws://me:p%40s@127.0.0.1:{bridge.port}/r%2F1?token=a%2Fb%2B%3D"
    settings = ros2_settings(0, transport="rosbridge", rosbridge_url=url).own(Ros2Settings)
    link = RosbridgeLink(settings, SystemClock(), mark=OURS)
    assert bridge.asked == ("/r%2F1?token=a%2Fb%2B%3D", "Basic bWU6cEBz")
    bridge.end()
    assert f"ws://127.0.0.1:{bridge.port}/r%2F1" in (told := failure(link))
    assert "token" not in told
    link.close()


@pytest.mark.system
@pytest.mark.parametrize("method", ["questions", "handle_answer"])
def test_an_unexpected_error_ends_the_link(
    bridge: Bridge, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    """Any exception in sending or receiving ends the link, and is logged and raised."""

    def broken(*_: object) -> None:
        raise RuntimeError("broken")

    with capture_logs() as logs, linked(bridge, OURS) as link:
        # Only once it is open: the constructor may raise if it fails at once.
        monkeypatch.setattr(RosbridgeGraph, method, broken)
        assert "RuntimeError" in failure(link)
        with pytest.raises(DriverError):
            link.send(CURVE, 0)
    assert [log["event"] for log in logs] == ["the link to the rosbridge server failed"]


class LateThread(SystemClock):
    """The link's own thread wakes 0.2 s late."""

    def now_s(self) -> float:
        late_s = 0.2 if threading.current_thread().name == "rosbridge" else 0.0
        return super().now_s() + late_s


@pytest.mark.system
def test_motion_from_before_a_freeze_is_not_sent(bridge: Bridge) -> None:
    """As the standby may have stopped the robot, late motion is dropped, standstill is not."""
    with linked(bridge, OURS, clock=LateThread()) as link:
        link.send(CURVE, 0)
        time.sleep(0.05)
        link.send(STANDSTILL, 0)
        end_s = time.monotonic() + 5.0
        while not (told := bridge.told()):
            assert time.monotonic() < end_s
            time.sleep(0.005)
    assert told[0].twist == STANDSTILL


@pytest.mark.system
@pytest.mark.timeout(20)
def test_an_early_refusal_is_raised(bridge: Bridge, monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread that wakes late from waiting for the connection still gets the reason."""
    bridge.type_name = "geometry_msgs/msg/TwistStamped"
    wait = threading.Event.wait

    def late(event: threading.Event, timeout: float | None = None) -> bool:
        is_set = wait(event, timeout)
        time.sleep(0.2)
        return is_set

    monkeypatch.setattr(threading.Event, "wait", late)
    with pytest.raises(DriverError, match="has been established"), linked(bridge, OURS):
        pass


@pytest.mark.system
def test_only_a_camera_accepts_large_messages(bridge: Bridge) -> None:
    """A message of a picture's size ends the commands' link, and reaches a camera's."""
    wanted = Wanted("camera", "/camera", "sensor_msgs/msg/CompressedImage")
    with linked(bridge, OURS, wanted) as commands, linked(bridge, "", wanted) as camera:
        end_s = time.monotonic() + 5.0
        while [one["op"] for one in bridge.heard].count("subscribe") < 2:
            assert time.monotonic() < end_s
            time.sleep(0.005)
        bridge.say("/camera", {"data": "x" * 1_200_000})
        ((kind, message),) = camera.take(5.0)
        assert (kind, len(message.data)) == ("camera", 1_200_000)
        assert "1000000" in failure(commands)
        camera.traffic()


@pytest.mark.system
@pytest.mark.alone
def test_the_standby_acts_for_a_killed_driver(bridge: Bridge) -> None:
    """By rosbridge, too, a second process sends standstill when the driver's is killed."""
    driver = opened(make_robot(by_bridge(bridge), SystemClock()))
    try:
        driven(bridge, driver, CURVE)
        at_s = time.monotonic()
        os.kill(int(driver.state().extra["driver_pid"]), signal.SIGKILL)
        time.sleep(1.7)
        zeros = [told for told in bridge.told() if told.at_s > at_s and told.twist.is_zero]
        assert zeros[0].at_s - at_s < 0.2
        assert len(zeros) >= 30
        assert max(b.at_s - a.at_s for a, b in itertools.pairwise(zeros)) < 0.25
    finally:
        driver.close()


@pytest.mark.system
@pytest.mark.full
def test_a_frozen_standby_holds_the_robot_until_another_is_ready(bridge: Bridge) -> None:
    """Without a standby that would act for a dead driver, the robot is not driven."""
    in_real_time = may_run_in_real_time()
    driver = make_driver(by_bridge(bridge), SystemClock())
    try:
        driven(bridge, opened(driver), CURVE)
        session: Any = vars(driver)["_session"]
        pid = session._standby._process.pid
        assert not in_real_time or os.sched_getscheduler(pid) == os.SCHED_RR
        os.kill(pid, signal.SIGSTOP)
        end_s = time.monotonic() + 2.0
        while driver.state().said is None:
            assert time.monotonic() < end_s
            feed(driver, CURVE, for_s=0.05)
        assert driver.state().said == STARTS
        epoch = driver.state().epoch
        standing(bridge)
        bridge.forget()
        feed(driver, CURVE, for_s=0.1)
        assert {told.twist for told in bridge.told()} == {STANDSTILL}
        until(driver, lambda state: state.connected)
        assert driver.state().epoch == epoch + 1
    finally:
        driver.close()


@pytest.mark.parametrize(("base", "lateral_mps"), [("differential", 0.0), ("omni", 0.6)])
def test_it_moves_sideways_if_its_base_does(base: str, lateral_mps: float) -> None:
    """The limits are the configuration's: they must be known before the robot answers."""
    settings = ros2_settings(0, base=base, transport="rosbridge")
    assert make_driver(settings, SystemClock()).limits.lateral_mps == lateral_mps


def test_commands_follow_the_protocol() -> None:
    """A publish has its op, its topic and the message's members by their ROS names."""
    assert json.loads(protocol.publish("/cmd_vel", SIDEWAYS)) == {
        "op": "publish",
        "topic": "/cmd_vel",
        "msg": {
            "linear": {"x": 0.25, "y": 0.125, "z": 0.0},
            "angular": {"x": 0.0, "y": 0.0, "z": -0.5},
        },
    }
    stamped = json.loads(
        protocol.publish("/cmd_vel", STANDSTILL, stamp=(1_500_000_000_000_000_007, "base"))
    )
    assert stamped["msg"]["header"] == {
        "stamp": {"sec": 1_500_000_000, "nanosec": 7},
        "frame_id": "base",
    }
    assert json.loads(protocol.call("7", "/rosapi/publishers", topic="/cmd_vel")) == {
        "op": "call_service",
        "id": "7",
        "service": "/rosapi/publishers",
        "args": {"topic": "/cmd_vel"},
    }


@pytest.mark.parametrize(
    "text",
    [
        "",
        "7",
        "[]",
        "null",
        '"op"',
        "{}",
        '{"op": 7}',
        '{"op": "publish"}',
        "[" * 100_000,
        '{"op": "publish", "topic": ["/odom"]}',
    ],
)
def test_an_invalid_message_is_refused_or_ignored(text: str) -> None:
    """Text outside the protocol is refused or has no effect."""
    try:
        heard = protocol.read(text)
    except ValueError:
        return
    assert heard is None or heard == protocol.Published("", None)


@pytest.mark.parametrize(
    ("said", "is_harmless"),
    [
        ({"msg": "no such service", "id": "wax:publishers"}, True),
        ({"msg": "no such type", "id": "wax-subscribe:/odom"}, True),
        ({"msg": "subscribe: no such type", "id": None}, True),
        ({"msg": "call_service: no such service", "id": 7}, True),
        ({"msg": "advertise: another type"}, False),
        ({"msg": "publish: no such member"}, False),
        ({"msg": "subscribe"}, False),
        ({"msg": [[7]]}, False),
        ({}, False),
    ],
)
def test_a_harmless_refusal_is_recognised(said: dict[str, object], is_harmless: bool) -> None:
    """Only a refusal known to concern an answer or a topic lets the robot be driven."""
    heard = protocol.read(json.dumps({"op": "status", "level": "error"} | said))
    assert isinstance(heard, protocol.Complaint)
    assert heard.is_harmless is is_harmless


def test_each_answer_of_rosapi_counts_for_itself() -> None:
    """Without the type, subscribers are still known, and none counts as of a wrong type."""
    graph = RosbridgeGraph("/cmd_vel", "/bridge")
    assert len(list(graph.questions(0.0))) == 3
    graph.handle_answer(protocol.ServiceAnswer("wax:topic_type", None), 0.0)
    graph.handle_answer(protocol.ServiceAnswer("wax:publishers", None), 0.0)
    graph.handle_answer(
        protocol.ServiceAnswer("wax:subscribers", SimpleNamespace(subscribers=[None, "/base", 7])),
        0.0,
    )
    traffic = graph.traffic(0.0)
    assert [subscriber.guid for subscriber in traffic.subscribers or ()] == ["/base"]
    assert judge(traffic, "/cmd_vel", TWIST, ()) is None


def _nested(levels: int) -> str:
    """Return a message of `levels`, with strings that look like more."""
    inside = r'"[[\"{{", ' * 50 + "[0]" + ", [1]" * 50
    return f'{{"op": "publish", "msg": {"[" * (levels - 2)}{inside}{"]" * (levels - 2)}}}'


def test_levels_are_bounded_by_us() -> None:
    """A message of 32 levels is read; a deeper one is refused, even if Python could read it."""
    assert isinstance(protocol.read(_nested(protocol.MOST_LEVELS)), protocol.Published)
    for levels in (protocol.MOST_LEVELS + 1, 300, 5000):
        with pytest.raises(ValueError, match="levels"):
            protocol.read(_nested(levels))
