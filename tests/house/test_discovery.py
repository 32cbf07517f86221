"""The discovery message, checked against Home Assistant's documentation of each platform."""

from __future__ import annotations

import json
import re
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from wax.config.settings import Settings
from wax.house.discovery import discovery
from wax.protocol.host_switches import AT_HOME

Text = Annotated[str, Field(min_length=1, max_length=255)]
Topic = Annotated[str, Field(pattern=r"^[^+#\x00$][^+#\x00]*$")]
"""A topic that can be published to."""


class _Schema(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Entity(_Schema):
    """https://www.home-assistant.io/integrations/mqtt/: options that all entities have."""

    unique_id: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]
    name: Text


class Sensor(_Entity):
    """…/integrations/sensor.mqtt/."""

    platform: Literal["sensor"]
    state_topic: Topic
    device_class: Literal["battery", "timestamp"] | None = None
    state_class: Literal["measurement", "total", "total_increasing"] | None = None
    unit_of_measurement: Text | None = None


class BinarySensor(_Entity):
    """…/integrations/binary_sensor.mqtt/; "ON" and "OFF" are the defaults."""

    platform: Literal["binary_sensor"]
    state_topic: Topic
    device_class: Literal["problem"] | None = None


class Way(_Schema):
    """…/integrations/mqtt/#using-availability-topics; "online" and "offline" are the defaults."""

    topic: Topic


class _Commanded(_Entity):
    """An entity with an availability list of its own, and so no `availability_topic`."""

    command_topic: Topic
    availability: Annotated[list[Way], Field(min_length=1)]
    availability_mode: Literal["all"]


class Button(_Commanded):
    """…/integrations/button.mqtt/."""

    platform: Literal["button"]
    command_template: Text | None = None


class Switch(_Commanded):
    """…/integrations/switch.mqtt/; "ON" and "OFF" are the defaults."""

    platform: Literal["switch"]
    state_topic: Topic


class Gone(_Schema):
    """An entry with nothing but its platform, which removes the entity."""

    platform: Literal["sensor", "button"]


class Device(_Schema):
    identifiers: Annotated[list[Text], Field(min_length=1)]
    name: Text
    manufacturer: Text
    sw_version: Text
    configuration_url: Annotated[str, Field(pattern="^https?://")] | None = None


class Origin(_Schema):
    name: Text
    sw_version: Text


class Payload(_Schema):
    """…/integrations/mqtt/#device-discovery-payload; device and origin are mandatory."""

    device: Device
    origin: Origin
    availability: list[Way]
    qos: Literal[0, 1, 2]
    components: dict[str, Sensor | BinarySensor | Button | Switch | Gone]


SCHEMA = TypeAdapter(Payload)
ROBOT_NAMES = st.text(
    st.characters(exclude_characters="\x7f", exclude_categories=["Cc", "Cs"]),
    min_size=1,
    max_size=40,
)


def _told(tree: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    topic, payload = discovery(Settings.model_validate(tree), "0.9.0")
    written = json.dumps(payload, ensure_ascii=False)
    SCHEMA.validate_json(written)
    told: dict[str, Any] = json.loads(written)
    return topic, told


@given(ROBOT_NAMES, st.booleans(), st.booleans())
def test_it_keeps_to_the_documentation(name: str, names: bool, release: bool) -> None:
    """The message is valid whatever the robot and its gauges are called, and its ids are unique."""
    gauge = {"name": "Motor_1", "label": name[:24], "unit": name[:8]}
    tree = {
        "page": {"name": name},
        "gauges": [gauge],
        "mqtt": {"names": names, "release": release},
        "server": {"public_url": "https://robot.example.org"},
    }
    topic, told = _told(tree)
    assert re.fullmatch(r"homeassistant/device/[a-zA-Z0-9_-]+/config", topic)
    assert told["device"]["name"] == name
    ids = [one["unique_id"] for one in told["components"].values() if "unique_id" in one]
    assert len(set(ids)) == len(ids)


def test_every_entity_is_there() -> None:
    """One device has all sensors, binary sensors, buttons and switches."""
    gauges = [{"name": "temperature", "label": "Motor", "unit": "°C"}]
    _, told = _told({"gauges": gauges, "mqtt": {"names": True, "release": True, "topic": "a/b"}})
    assert {key: one["platform"] for key, one in told["components"].items()} == {
        "queue": "sensor",
        "viewers": "sensor",
        "battery": "sensor",
        "gauge_temperature": "sensor",
        "last_stop": "sensor",
        "last_stop_reason": "sensor",
        "driver": "sensor",
        "fault": "binary_sensor",
        "open": "binary_sensor",
        "stop": "button",
        "release": "button",
        **{f"{topic}_switch": "switch" for topic in AT_HOME},
    }
    assert told["availability"] == [{"topic": "a/b/status"}]
    assert told["components"]["gauge_temperature"]["state_topic"] == "a/b/gauge/temperature"
    assert told["components"]["stop"]["command_topic"] == "a/b/stop/set"


def test_what_commands_is_there_while_its_way_leads_here() -> None:
    """A button or switch is available while the robot is online and its own commands arrive."""
    _, told = _told({"mqtt": {"release": True, "topic": "a/b"}})
    ways = {
        key: [way["topic"] for way in one["availability"]]
        for key, one in told["components"].items()
        if "command_topic" in one
    }
    assert ways == {
        "stop": ["a/b/status", "a/b/stop/status"],
        "release": ["a/b/status", "a/b/release/status"],
        **{f"{topic}_switch": ["a/b/status", f"a/b/{topic}/status"] for topic in AT_HOME},
    }


def test_what_is_not_allowed_is_removed() -> None:
    """The driver's name and Release are offered only if configured."""
    _, told = _told({})
    assert told["components"]["driver"] == {"platform": "sensor"}
    assert told["components"]["release"] == {"platform": "button"}


@pytest.mark.parametrize("prefix", ["ha", "home/assistant"])
def test_the_prefix_is_configured(prefix: str) -> None:
    """The discovery prefix is configurable, as it is in Home Assistant."""
    assert _told({"mqtt": {"discovery": prefix}})[0] == f"{prefix}/device/wax_wax/config"
