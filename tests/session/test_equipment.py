"""The robot's controls and gauges: what pages may set, and who is told what."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest
from tests.session.rig import FakePeer, Rig
from tests.session.viewer_rig import connect

from wax.config.controls import ControlSettings, GaugeSettings
from wax.control.controls import Operation
from wax.control.reasons import Refusal
from wax.driver.interface import RobotState
from wax.protocol.messages import MAX_DRIVE_BYTES
from wax.session import equipment

if TYPE_CHECKING:
    from collections.abc import Mapping

CONTROLS: list[dict[str, Any]] = [
    {"name": "lamp", "label": "Lamp", "kind": "toggle", "roles": ["operator", "observer"]},
    {"name": "horn", "kind": "button", "key": "KeyG"},
]
GAUGES: list[dict[str, Any]] = [
    {"name": "heat", "unit": "°C", "decimals": 0, "warn_above": 60.0, "stop_above": 80.0},
    {"name": "wind"},
]


@pytest.fixture
def rig() -> Rig:
    rig = Rig({"controls": CONTROLS, "gauges": GAUGES})
    rig.robot.gauges = {"heat": 20.4, "secret": 1.0}
    return rig


def operate(
    rig: Rig,
    peer: FakePeer,
    seq: int,
    *,
    held: Mapping[str, float] | None = None,
    wanted: Mapping[str, float] | None = None,
) -> Any:
    """Send what a page holds and sets; return the answer, None if there is none."""
    peer.pings()
    before = len(peer.rows)
    turn = rig.room.snapshot(rig.clock.time_s).turn.number
    row = ["operate", seq, turn, rig.clock.time_s * 1000, held or {}, wanted or {}, peer.beat]
    peer.events.received("drive", json.dumps(row))
    return peer.rows[-1] if peer.rows[before:] else None


async def test_a_newcomer_gets_the_controls_and_gauges(rig: Rig) -> None:
    """The greeting has labels, keys and roles; the values come with the room's state."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.1, ada)
    hello, room = ada.last("hello"), ada.last("room")
    assert hello["controls"] == [
        {
            "name": "lamp",
            "label": "Lamp",
            "kind": "toggle",
            "min": 0.0,
            "max": 1.0,
            "step": 0.05,
            "choices": [],
            "key": "",
            "pad_button": "",
            "moves": False,
            "roles": ["operator", "observer"],
        },
        hello["controls"][1] | {"name": "horn", "label": "horn", "key": "KeyG"},
    ]
    assert [one["label"] for one in hello["gauges"]] == ["heat", "wind"]
    assert room["controls"] == {}
    assert room["robot"]["gauges"] == {"heat": 20}
    assert room["robot"]["beyond"] == {}


async def test_everybody_learns_what_was_set(rig: Rig) -> None:
    """The page that set it reads the answer, the others the room's state a moment later."""
    ada, eve = await rig.enter("ada-1111"), await rig.enter("eve-1111")
    rig.wait(0.1, ada, eve)
    assert operate(rig, eve, 1, wanted={"lamp": 1}) == ["operated", 1, None]
    rig.wait(0.1, ada, eve)
    assert ada.room["controls"] == eve.room["controls"] == {"lamp": 1.0}
    assert rig.robot.told.count(("lamp", True)) == 1


async def test_a_refused_operation_says_why(rig: Rig) -> None:
    """The answer is a sentence, and nothing happens."""
    ada, eve = await rig.enter("ada-1111"), await rig.enter("eve-1111")
    ada.says(type="join")
    rig.wait(0.1, ada, eve)
    answer = operate(rig, eve, 1, held={"horn": 1})
    assert answer == ["operated", 1, {"code": "drive.not_your_turn"}]
    rig.wait(0.1, ada, eve)
    assert ("horn", True) not in rig.robot.told
    rig.drive(ada, 1, linear=0.0)
    assert operate(rig, ada, 1, held={"horn": 1}) == ["operated", 1, None]
    rig.wait(0.1, ada, eve)
    assert ("horn", True) in rig.robot.told
    assert operate(rig, ada, 2) is None  # a release is not waited for
    rig.wait(0.1, ada, eve)
    assert ("horn", False) in rig.robot.told


async def test_a_gauge_beyond_its_limit_is_reported_at_once(rig: Rig) -> None:
    """Its value changes all the time and is sent now and then; a warning is not delayed."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.1, ada)
    rig.robot.gauges = {"heat": 25.0}
    rig.wait(1.0, ada)
    assert ada.room["robot"]["gauges"] == {"heat": 20}
    rig.robot.gauges = {"heat": 60.5}
    rig.wait(0.3, ada)
    assert ada.room["robot"]["beyond"] == {"heat": "warn"}
    assert ada.room["robot"]["gauges"] == {"heat": 60}
    rig.robot.gauges = {}
    rig.wait(0.3, ada)
    assert ada.room["robot"]["beyond"] == {"heat": "stop"}


def test_a_disconnected_robot_warns_of_nothing() -> None:
    """The page says anyway that the robot is not connected."""
    gauges = [GaugeSettings(name="heat", stop_above=80.0)]
    assert equipment.beyond(gauges, RobotState(connected=False)) == {}
    assert equipment.beyond(gauges, RobotState(connected=True)) == {"heat": "stop"}


async def test_a_viewer_in_a_livekit_room_has_no_controls(rig: Rig) -> None:
    """There is no channel for controls from a LiveKit room; gauges may be read."""
    ada = await rig.enter("ada-1111")
    visitor = ada.events.visitor  # type: ignore[attr-defined]  # a viewer
    grant = ada.events.grant  # type: ignore[attr-defined]
    hello = rig.room._page_messages.hello(0, visitor, grant)
    assert hello.controls == []
    assert len(hello.gauges) == 2


# --- one viewer's messages ------------------------------------------------------------------------


def _row(seq: int = 1, held: object = None, wanted: object = None) -> str:
    return json.dumps(["operate", seq, 3, 5000.0, held or {}, wanted or {}, None])


def test_an_operation_is_passed_on() -> None:
    """Its time becomes seconds, and all else stays the same."""
    connected = connect()
    connected.viewer.received("drive", _row(held={"horn": 1}, wanted={"lamp": 0}))
    assert connected.room.calls[1:] == [("operate", Operation(1, 3, 5.0, {"horn": 1}, {"lamp": 0}))]
    assert ("drive", ["operated", 1, None]) in connected.room.sent


@pytest.mark.parametrize("refusal", Refusal)
def test_an_operation_that_was_only_late_is_not_answered(refusal: Refusal) -> None:
    """The page repeats it; every other refusal is final and has a sentence."""
    connected = connect()
    connected.room.refusal = refusal
    connected.viewer.received("drive", _row(wanted={"lamp": 0}))
    late = {Refusal.OUT_OF_ORDER, Refusal.TOO_OLD, Refusal.TOO_SLOW, Refusal.FROM_FUTURE}
    answer = ["operated", 1, {"code": refusal.value.code}]
    drive = [said for channel, said in connected.room.sent if channel == "drive"]
    answers = [said for said in drive if said[0] == "operated"]
    assert answers == ([] if refusal in late else [answer])


def test_settings_are_accepted_at_a_bounded_rate() -> None:
    """Nobody can make the robot's lights flicker; holding and releasing always count."""
    connected = connect()
    for seq in range(1000):
        connected.clock.time_s += 0.02
        connected.viewer.received("drive", _row(seq, wanted={"lamp": seq % 2}))
    assert 200 <= len(connected.room.calls) <= 221
    connected.room.calls.clear()
    for seq in range(1000):
        connected.clock.time_s += 0.02
        connected.viewer.received("drive", _row(seq, held={"horn": 1}))
        connected.viewer.received("drive", _row(seq))
    assert len(connected.room.calls) == 2000


def test_the_longest_operation_fits() -> None:
    """It has the longest names and numbers, and as many as there may be."""
    names = [f"{at}" + "x" * 15 for at in "abcdef"]
    held = dict.fromkeys(names[:4], -9999.123)
    wanted = dict.fromkeys(names[4:], -9999.123)
    row = ["operate", 2**31, 2**24, 1_234_567_890.1, held, wanted]
    assert len(json.dumps(row, separators=(",", ":"))) <= MAX_DRIVE_BYTES
    ControlSettings(name=names[0], kind="toggle")
