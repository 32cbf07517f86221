"""The room's state for home automation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.config.controls import GaugeSettings
from wax.config.settings import Settings
from wax.house.discovery import published_topics
from wax.protocol.host_switches import AT_HOME
from wax.session.house_states import house_states

if TYPE_CHECKING:
    from tests.session.rig import Rig


async def test_the_room_as_states(rig: Rig) -> None:
    """Numbers are text, unknown values "None", and the driver is named only where names are sent.

    Elsewhere the driver is empty, which deletes what the broker has retained.
    """
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.3, ada, bob)
    bob.says(type="join")
    rig.wait(0.3, ada, bob)
    gauges = [GaugeSettings(name="amps", decimals=2), GaugeSettings(name="gone")]
    room = rig.room.snapshot(rig.clock.time_s)
    robot = room.robot.model_copy(update={"battery_fraction": 0.424, "gauges": {"amps": 1.5}})
    room = room.model_copy(update={"robot": robot})
    told = house_states(room, gauges, is_open=True, names=False)
    assert told == {
        "driver": "",
        "queue": "1",
        "viewers": "2",
        "battery": "42",
        **dict.fromkeys(AT_HOME, "OFF"),
        "open": "ON",
        "gauge/amps": "1.50",
        "gauge/gone": "None",
    }
    known = {"gauges": [one.model_dump() for one in gauges], "mqtt": {"topic": "rover"}}
    topics = published_topics(Settings.model_validate(known))
    assert {f"rover/{key}" for key in told} < set(topics), "`wax doctor` tries them all"
    assert house_states(room, (), is_open=False, names=True)["driver"] == "Guest 1"
    empty = house_states(
        room.model_copy(update={"turn": room.turn.model_copy(update={"operator": None})}),
        (),
        is_open=False,
        names=True,
    )
    assert (empty["driver"], empty["open"]) == ("None", "OFF")
