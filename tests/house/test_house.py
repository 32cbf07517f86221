"""Messages to and from the broker, without a broker."""

from __future__ import annotations

import asyncio
import json
import sys
from typing import TYPE_CHECKING, Any, cast

import pytest
import structlog
from tests.turned_clock import TurnedClock, turn_loop
from tests.until import async_until

from wax.config.settings import Settings
from wax.errors import ForbiddenError, StartError
from wax.house import broker, commands
from wax.house.discovery import published_topics
from wax.house.house import GAP_S, House
from wax.protocol import messages
from wax.protocol.events import FaultEvent, Removed, StopEvent, StoppedByItself
from wax.protocol.host_switches import AT_HOME, Close
from wax.sentence import Sentence

if TYPE_CHECKING:
    from pathlib import Path

    from wax.house.commands import HouseAct


class Link:
    """A fake link that records what it is given."""

    name = "home:1883"
    problem: Sentence | None = None
    troubles: tuple[Sentence, ...] = ()
    is_connected = True
    lost = expired = 0

    def __init__(
        self, *_: object, topic: str, asks: dict[str, str], birth: str, deliver: object
    ) -> None:
        self.topic, self.asks, self.birth = topic, asks, birth
        self.states: dict[str, str] = {}
        self.events: list[dict[str, Any]] = []

    def put(self, event: str) -> None:
        self.events.append(json.loads(event))

    def start(self) -> None: ...

    def close(self, limit_s: float) -> None:
        self.ended_within_s = limit_s


class Rig:
    """A house with a fake link and a clock."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **mqtt: Any) -> None:
        monkeypatch.setattr(broker, "BrokerLink", Link)
        self.clock = TurnedClock()
        self.acts: list[HouseAct] = []
        self.seen = {"queue": "0"}
        self.refuses = False
        tree = {"mqtt": {"url": "mqtt://home", "topic": "rover", **mqtt}}
        self.settings = Settings.model_validate(tree)
        self.house = House(self.settings, self.clock, seen=lambda: self.seen, act=self._act)
        self.link = cast("Link", self.house._link)

    def _act(self, act: HouseAct) -> None:
        if self.refuses:
            raise ForbiddenError(Sentence("may.operator"))
        self.acts.append(act)

    def hears(self, name: str, payload: bytes, *, retained: bool = False) -> None:
        self.house.receive(f"rover/{name}/set", payload, retained)


@pytest.fixture
async def rig(monkeypatch: pytest.MonkeyPatch) -> Rig:
    rig = Rig(monkeypatch)
    rig.house._loop = asyncio.get_running_loop()
    return rig


def _states(rig: Rig) -> dict[str, str]:
    rig.house._refresh_states()
    return {topic: one for topic, one in rig.link.states.items() if topic.startswith("rover/")}


async def test_states_are_what_is_seen_and_what_was_told(rig: Rig) -> None:
    """Faults are on until all are mended; the last Stop has its role or reason."""
    assert _states(rig) == {
        "rover/queue": "0",
        "rover/fault": "OFF",
        "rover/last_stop": "None",
        "rover/last_stop_reason": "None",
    }
    for part in ("camera", "battery"):
        event = FaultEvent(type="fault.began", part=part, which=None, why="x")
        rig.house.put(event)
    rig.house.put(FaultEvent(type="fault.mended", part="camera", which=None, why="x"))
    rig.house.put(StoppedByItself(viewer=1, why="blind", name=None, timestamp="12:00"))
    told = _states(rig)
    assert told["rover/fault"] == "ON"
    assert (told["rover/last_stop"], told["rover/last_stop_reason"]) == ("12:00", "blind")
    rig.house.put(FaultEvent(type="fault.mended", part="battery", which=None, why="x"))
    rig.house.put(
        StopEvent(type="stop.pressed", stop=1, role="house", name=None, timestamp="13:00")
    )
    rig.house.put(
        StopEvent(type="stop.released", stop=1, role="host", name=None, timestamp="14:00")
    )
    told = _states(rig)
    assert told["rover/fault"] == "OFF"
    assert told["rover/last_stop"] == "13:00"
    assert told["rover/last_stop_reason"] == "pressed (house)"


async def test_home_assistant_is_told_unless_configured_otherwise(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The discovery message is published among the states unless `discovery` is empty.

    `wax doctor` knows beforehand what is published.
    """
    _states(rig)
    assert "homeassistant/device/rover/config" in rig.link.states
    assert set(rig.link.states) < set(published_topics(rig.settings))
    other = Rig(monkeypatch, discovery="")
    _states(other)
    assert all(topic.startswith("rover/") for topic in other.link.states)
    assert all(topic.startswith("rover/") for topic in published_topics(other.settings))


@pytest.mark.parametrize(("names", "name"), [(False, None), (True, "Eve")])
async def test_names_are_told_only_where_configured(
    monkeypatch: pytest.MonkeyPatch, names: bool, name: str | None
) -> None:
    """An event names people only if `names` is true."""
    rig = Rig(monkeypatch, names=names)
    rig.house.put(Removed(type="viewer.banned", viewer=2, name="Eve"))
    assert [one["name"] for one in rig.link.events] == [name]


async def test_only_what_may_act_is_listened_to(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command but Release is subscribed to, and Release if configured."""
    names = ["stop", *AT_HOME]
    assert sorted(rig.link.asks) == sorted(f"rover/{name}/set" for name in names)
    assert "rover/release/set" in Rig(monkeypatch, release=True).link.asks
    assert rig.link.asks["rover/stop/set"] == "rover/stop/status"


async def test_home_assistants_start_is_heard_where_it_is_told(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The birth topic has the discovery prefix; it is empty without discovery."""
    assert rig.link.birth == "homeassistant/status"
    assert Rig(monkeypatch, discovery="").link.birth == ""


async def test_a_command_acts_at_once_and_is_seen(rig: Rig) -> None:
    """A command acts and updates the states at once."""
    rig.seen = {"queue": "7"}
    rig.hears("stop", b"PRESS")
    await asyncio.sleep(0)
    assert rig.acts == [messages.Stop(type="stop")]
    assert rig.link.states["rover/queue"] == "7"


@pytest.mark.parametrize("name", commands.NAMES)
async def test_a_retained_copy_does_nothing(rig: Rig, name: str) -> None:
    """Retained and empty messages are ignored and counted, except an empty Stop."""
    rig.hears(name, b"ON", retained=True)
    rig.hears(name, b"", retained=True)
    await asyncio.sleep(0)
    assert rig.acts == []
    rig.hears(name, b"")
    await asyncio.sleep(0)
    stops = name == "stop"
    assert rig.acts == ([messages.Stop(type="stop")] if stops else [])
    assert rig.house.counts["retained"] == (2 if stops else 3)


async def test_what_nobody_asked_for_does_nothing(rig: Rig) -> None:
    """A message to another topic uses no memory and no pass of the event loop."""
    for number in range(1000):
        rig.hears(f"{number}", b"ON")
        rig.house.receive(f"other/{number}", b"ON", False)
    assert rig.house._newest == {}


async def test_a_flood_reaches_the_loop_as_a_trickle(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a topic's flood the first acts at once and then the newest; other topics do not wait."""
    for number in range(1000):
        rig.hears("open", b"OFF" if number < 999 else b"ON")
    rig.hears("stop", b"PRESS")
    await asyncio.sleep(0)
    assert rig.acts == [
        Close(type="close", closed=False),
        messages.Stop(type="stop"),
    ]
    assert rig.house.counts["overtaken"] == 999
    for _ in range(1000):
        rig.hears("open", b"OFF")
    rig.hears("open", b"ON")
    await asyncio.sleep(0)
    assert len(rig.acts) == 2
    turn_loop(GAP_S, monkeypatch)
    await async_until(lambda: len(rig.acts) > 2)
    assert rig.acts[2:] == [Close(type="close", closed=False)]
    assert rig.house._acted_s["open"] == rig.clock.time_s
    rig.clock.time_s += GAP_S
    rig.hears("open", b"OFF")
    await asyncio.sleep(0)
    assert rig.acts[3:] == [Close(type="close", closed=True)]


async def test_a_second_press_of_stop_acts_in_time(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second Stop acts within 100 ms: somebody may have released the first."""
    for _ in range(2):
        rig.hears("stop", b"PRESS")
        await asyncio.sleep(0)
    turn_loop(0.04, monkeypatch)
    await async_until(lambda: rig.acts == [messages.Stop(type="stop")] * 2)


async def test_garbage_is_one_line(rig: Rig) -> None:
    """Each invalid message is counted, and the first is logged."""
    with structlog.testing.capture_logs() as logs:
        for _ in range(3):
            rig.hears("open", b"\xff")
            await asyncio.sleep(0)
            rig.clock.time_s += GAP_S
    assert rig.acts == []
    assert rig.house.counts["garbage"] == 3
    assert [(one["event"], one["topic"]) for one in logs] == [
        ("a message by MQTT is none of ours", "open")
    ]


async def test_a_refusal_is_counted_and_said(rig: Rig) -> None:
    """A refused command is counted and logged with its reason."""
    rig.refuses = True
    with structlog.testing.capture_logs() as logs:
        rig.hears("paused", b"ON")
        await asyncio.sleep(0)
    assert rig.house.counts["refused"] == 1
    assert logs[0]["why"] == str(Sentence("may.operator"))


async def test_the_host_reads_a_refusal_for_a_minute(rig: Rig) -> None:
    """The host sees why a command was refused, for 60 s."""
    rig.refuses = True
    rig.hears("paused", b"ON")
    await asyncio.sleep(0)
    said = f"What somebody wanted by MQTT was refused: {Sentence('may.operator')}"
    assert [str(one) for one in rig.house.problems()] == [said]
    rig.clock.time_s += 60.0
    assert rig.house.problems() == []


async def test_a_bug_here_reaches_nobody(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception in `seen`, `act` or the link is logged once and goes no further."""

    def fail(*_: object) -> None:
        raise RuntimeError("bug")

    monkeypatch.setattr(rig.house, "_seen", fail)
    monkeypatch.setattr(rig.house, "_act", fail)
    monkeypatch.setattr(rig.link, "put", fail)
    with structlog.testing.capture_logs() as logs:
        rig.hears("paused", b"ON")
        await asyncio.sleep(0)
        rig.house.put(Removed(type="viewer.banned", viewer=2, name="Eve"))
        rig.house._refresh_states()
    assert [one["event"] for one in logs] == ["the house is not told"]


async def test_the_end_waits_a_second_at_most(rig: Rig) -> None:
    """`close` gives the link a second at most."""
    await rig.house.close()
    assert rig.link.ended_within_s <= 1.0


async def test_the_host_reads_that_the_broker_is_away(rig: Rig) -> None:
    """The host reads that the connection is lost, and why."""
    assert rig.house.problems() == []
    rig.link.problem = Sentence("unreachable.silent", {"limit": 10.0})
    assert [str(one) for one in rig.house.problems()] == [
        "There is no connection to the MQTT broker home:1883; WAX keeps trying."
        " It does not answer within 10 s."
    ]
    told = rig.house.status()
    assert told is not None
    assert told["problem"] == "It does not answer within 10 s."


async def test_the_host_reads_what_the_broker_keeps_from_the_robot(rig: Rig) -> None:
    """Troubles are on the page and in the status; a lost connection replaces them."""
    rig.link.troubles = (Sentence("house.not_kept", {"topic": "rover/status"}),)
    assert rig.house.problems() == list(rig.link.troubles)
    told = rig.house.status()
    assert told is not None
    assert told["problem"] == str(rig.link.troubles[0])
    rig.link.problem = Sentence("hook.silent", {"limit": 10.0})
    assert [one.code for one in rig.house.problems()] == ["house.away"]


def test_without_a_url_nothing_is_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a `url`, the link's module is not imported and events are dropped."""
    monkeypatch.setitem(sys.modules, "wax.house.broker", None)
    house = House(Settings(), TurnedClock(), seen=dict, act=lambda _: None)
    house.put(Removed(type="viewer.banned", viewer=2, name="Eve"))
    assert (house.status(), house.problems()) == (None, [])


def test_a_missing_library_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sentence has the command that installs the missing library."""
    monkeypatch.setitem(sys.modules, "wax.house.broker", None)
    settings = Settings.model_validate({"mqtt": {"url": "mqtt://home"}})
    with pytest.raises(StartError, match=r'pip install "wax-teleop\[mqtt\]"'):
        House(settings, TurnedClock(), seen=dict, act=lambda _: None)


@pytest.mark.parametrize(
    ("keys", "text", "says"),
    [
        ({"user": "rover", "password_file": "{}"}, None, "mqtt.password_file: .* cannot be read"),
        ({"user": "rover", "password_file": "{}"}, "\n", "mqtt.password_file: .* is empty"),
        ({"user": "rover", "password_file": "{}"}, "x" * 5000, "mqtt.password_file: .* more than"),
        ({"url": "mqtts://home", "ca_file": "{}"}, None, "mqtt.ca_file: .* No such file"),
        ({"url": "mqtts://home", "ca_file": "{}"}, "x", "mqtt.ca_file: .* holds no certificate"),
        ({"url": "mqtts://home", "ca_file": "{}"}, "", "mqtt.ca_file: .* holds no certificate"),
    ],
)
def test_what_cannot_be_read_keeps_the_server_from_starting(
    tmp_path: Path, keys: dict[str, str], text: str | None, says: str
) -> None:
    """A file that cannot be used is a `StartError` that names its key."""
    path = tmp_path / "file"
    if text is not None:
        path.write_text(text)
    mqtt = {"url": "mqtt://home"} | {key: one.format(path) for key, one in keys.items()}
    settings = Settings.model_validate({"mqtt": mqtt})
    with pytest.raises(StartError, match=says):
        House(settings, TurnedClock(), seen=dict, act=lambda _: None)
