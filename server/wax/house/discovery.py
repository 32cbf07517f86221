"""How Home Assistant finds the robot: MQTT discovery of one device with its components. Pure.

One message describes the whole device (Home Assistant 2024.11 and later), not one each entity: the
device appears at once or not at all, and the next start removes what the configuration no longer
allows. https://www.home-assistant.io/integrations/mqtt/#device-discovery-payload
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from wax.house import commands
from wax.house.slug import slug
from wax.protocol.host_switches import AT_HOME
from wax.protocol.robot_report import HOUSE_SENSORS

if TYPE_CHECKING:
    from wax.config.settings import Settings

STATUS: Final = "status"
EVENT: Final = "event"
DRIVER: Final = "driver"
ONLINE: Final = "online"
OFFLINE: Final = "offline"

_RELEASED: Final = "{{ (now().timestamp() * 1000) | int }}"
"""Home Assistant's template for the time of a press, in the unit of `ReleaseAt`."""
_MEASURED: Final = {"state_class": "measurement"}


def topic_of(settings: Settings) -> str:
    """Return the prefix of all topics of this robot."""
    return settings.mqtt.topic or f"wax/{slug(settings.page.name)}"


def command_topic(topic: str, name: str) -> str:
    return f"{topic}/{name}/set"


def way_topic(topic: str, name: str) -> str:
    """Return the topic that says whether messages to the `command_topic` arrive."""
    return f"{topic}/{name}/{STATUS}"


def birth_topic(settings: Settings) -> str:
    """Return the topic of Home Assistant's birth message; empty if discovery is off."""
    return f"{settings.mqtt.discovery}/{STATUS}" if settings.mqtt.discovery else ""


def gauge_key(name: str) -> str:
    """Return the last levels of a gauge's topic; its id has "_" for "/"."""
    return f"gauge/{name}"


def published_topics(settings: Settings) -> list[str]:
    """Return every topic that this server publishes to."""
    where, device = discovery(settings, "")
    topic, components = topic_of(settings), device["components"].values()
    found = [where] if settings.mqtt.discovery else []
    found += [f"{topic}/{level}" for level in (STATUS, EVENT, DRIVER)]
    found += [way["topic"] for one in components for way in one.get("availability", [])]
    found += [one["state_topic"] for one in components if "state_topic" in one]
    return list(dict.fromkeys(found))


def discovery(settings: Settings, software: str) -> tuple[str, dict[str, Any]]:
    """Return the topic and the payload of the message, which must be retained."""
    topic, mqtt, page = topic_of(settings), settings.mqtt, settings.page
    own_id = slug(topic)
    components: dict[str, dict[str, Any]] = {}

    def add(key: str, platform: str, name: str, **more: object) -> None:
        components[key] = {"platform": platform, "unique_id": f"{own_id}_{key}", "name": name}
        components[key] |= more

    def shows(key: str, platform: str, name: str, **more: object) -> None:
        add(key.replace("/", "_"), platform, name, state_topic=f"{topic}/{key}", **more)

    def commands_by(key: str) -> dict[str, object]:
        """Return keys that show a component as unavailable while its commands do not arrive."""
        ways = [{"topic": one} for one in (f"{topic}/{STATUS}", way_topic(topic, key))]
        return {
            "command_topic": command_topic(topic, key),
            "availability": ways,
            "availability_mode": "all",
        }

    def button(key: str, name: str, **more: object) -> None:
        add(key, "button", name, **commands_by(key), **more)

    shows("queue", "sensor", "Queue", **_MEASURED)
    shows("viewers", "sensor", "Viewers", **_MEASURED)
    for one in HOUSE_SENSORS:
        shows(one.topic, "sensor", one.name, **one.keys)
    for gauge in settings.gauges:
        unit = {"unit_of_measurement": gauge.unit} if gauge.unit else {}
        name = gauge.label or gauge.name
        shows(gauge_key(gauge.name), "sensor", name, **_MEASURED, **unit)
    shows("last_stop", "sensor", "Last stop", device_class="timestamp")
    shows("last_stop_reason", "sensor", "Last stop's reason")
    shows("fault", "binary_sensor", "Fault", device_class="problem")
    shows("open", "binary_sensor", "Open")
    button(commands.STOP, "Stop")
    for key, switch in AT_HOME.items():
        more = commands_by(key) | {"state_topic": f"{topic}/{key}"}
        add(f"{key}_switch", "switch", switch.name, **more)
    # An entry with nothing but its platform removes a component that is not allowed (any more).
    if mqtt.names:
        shows(DRIVER, "sensor", "Driver")
    else:
        components[DRIVER] = {"platform": "sensor"}
    if mqtt.release:
        button(commands.RELEASE, "Release", command_template=_RELEASED)
    else:
        components[commands.RELEASE] = {"platform": "button"}
    page_url = {"configuration_url": settings.server.public_url}
    return f"{mqtt.discovery}/device/{own_id}/config", {
        "device": {"identifiers": [own_id], "name": page.name, "manufacturer": "WAX"}
        | {"sw_version": software}
        | (page_url if settings.server.public_url else {}),
        "origin": {"name": "WAX", "sw_version": software},
        # A list, which a component's own list replaces; Home Assistant refuses a list together
        # with an `availability_topic`.
        "availability": [{"topic": f"{topic}/{STATUS}"}],
        "qos": 1,
        "components": components,
    }
