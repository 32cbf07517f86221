"""`[mqtt]`: the broker that connects the robot with the house's automation."""

from __future__ import annotations

from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, model_validator

from wax.config.addresses import ONE_URL
from wax.config.table import ConfigTable


def _whole(url: str) -> str:
    if url and urlsplit(url).port == 0:  # raises ValueError for what is no port
        raise ValueError("Port 0 is none")
    return url


class MqttSettings(ConfigTable):
    """MQTT is off without a `url`."""

    url: Annotated[
        str,
        Field(
            pattern=r"^(mqtts?://(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9][A-Za-z0-9._-]{0,252})(:\d{1,5})?)?$",
            description='empty, or an address as "mqtts://broker.example.org", without a user\'s'
            " name",
        ),
        ONE_URL,
        AfterValidator(_whole),
    ] = ""
    user: Annotated[str, Field(max_length=200)] = ""
    password_file: str = ""
    ca_file: str = ""
    topic: Annotated[
        str,
        Field(
            pattern=r"^([^$/+#\x00-\x1f\x7f-\x9f][^/+#\x00-\x1f\x7f-\x9f]*(/[^/+#\x00-\x1f\x7f-\x9f]+)*)?$",
            max_length=100,
            description='empty, or levels as "home/rover": at most 100 printable characters without'
            ' "+", "#", a "$" at the beginning or a "/" at either end',
        ),
    ] = ""
    names: bool = False
    release: bool = False
    discovery: Annotated[
        str,
        Field(
            pattern=r"^([A-Za-z0-9_-]+(/[A-Za-z0-9_-]+)*)?$",
            max_length=100,
            description='empty, or levels of letters, digits, "_" and "-"',
        ),
    ] = "homeassistant"

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        if self.password_file and not self.user:
            raise ValueError("there is a password_file without a user; name who has that password")
        if self.ca_file and not self.url.startswith("mqtts:"):
            raise ValueError("ca_file is for an encrypted connection; write url as mqtts://")
        return self
