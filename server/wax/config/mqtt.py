"""`[mqtt]`: the broker that connects the robot with the house's automation."""

from __future__ import annotations

from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, model_validator

from wax.config.addresses import ONE_URL
from wax.config.allowed import said
from wax.config.table import ConfigTable


def _whole(url: str) -> str:
    if url and urlsplit(url).port == 0:  # raises ValueError for what is no port
        raise ValueError("Port 0 is none")
    return url


class MqttSettings(ConfigTable):
    """The broker of your house's automation, by MQTT 5 (`pip install "wax-teleop[mqtt]"`). Home
    Assistant, from 2024.11 on, finds the robot there by itself. These are retained below `topic`,
    as text:
      status                 "online" or "offline", as the broker tells when this server is gone
      NAME/status            "online" while what is sent to NAME/set arrives, of each NAME below
      queue, viewers         how many wait, and watch
      battery                per cent, "None" while nobody knows
      gauge/NAME             of each [[gauges]], "None" while the robot does not tell it
      open, paused, blanked  "ON" or "OFF"; paused is the queue
      fault                  "ON" while a fault of those in [[hook]] lasts
      last_stop              when, as 2026-11-26T12:00:00.000+00:00
      last_stop_reason       "pressed (ROLE)", or why as in stop.automatic
      driver                 who drives, "None" while nobody does; only with `names`
    Events go to `event` as they happen, as in [[hook]], and are not retained. These are heard:
      stop/set     anything, or nothing: Stop, which lasts until somebody releases it
      open/set, paused/set, blanked/set  "ON" or "OFF": as you do in the panel Host
      release/set  the Unix time in ms when it was wanted, at most 2 s ago by this machine's clock;
                   only with `release`, and never a Stop of your own
    The server sends itself a "wax-probe …" by each of these every 30 s, which asks for nothing;
    while none comes back within 3 s, Home Assistant offers no button or switch for it. So let the
    server's user at the broker read and write below `topic`, write below `discovery`, and read
    `discovery`/status: "online" there has everything said again. Nobody can drive from there.
    Retained messages to these topics are ignored, even a Stop: they would act again at each new
    connection. Of many messages to one topic the newest counts, at most five times a second; a
    broker that sends 2,000 a second is disconnected, and tried again. Anybody who can publish to
    them can stop and close the robot: let the broker ask for a password.

    This Stop is no emergency stop: it needs the connection, and "offline" appears up to 25 s late.
    """

    url: Annotated[
        str,
        Field(
            pattern=r"^(mqtts?://(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9][A-Za-z0-9._-]{0,252})(:\d{1,5})?)?$"
        ),
        said('empty, or an address as "mqtts://broker.example.org", without a user\'s name'),
        ONE_URL,
        AfterValidator(_whole),
    ] = ""
    """The broker's address: mqtts:// if it is encrypted (otherwise a password can be read on the
    way), and ":PORT" if that is not 8883 or 1883. Driving never waits for the broker; the
    connection is tried for ever, at least every 30 s."""
    user: Annotated[str, Field(max_length=200)] = ""
    """The name of this server's user at the broker."""
    password_file: str = ""
    """The file that holds that user's password."""
    ca_file: str = ""
    """The file with your own CA certificate, if that CA signed the broker's. If empty, the CAs that
    this machine trusts count, or those in the file that the environment variable SSL_CERT_FILE
    names. Verification cannot be switched off."""
    topic: Annotated[
        str,
        Field(
            pattern=r"^([^$/+#\x00-\x1f\x7f-\x9f][^/+#\x00-\x1f\x7f-\x9f]*(/[^/+#\x00-\x1f\x7f-\x9f]+)*)?$",
            max_length=100,
        ),
        said(
            'empty, or levels as "home/rover": at most 100 printable characters without'
            ' "+", "#", a "$" at the beginning or a "/" at either end'
        ),
    ] = ""
    """What all topics begin with; if empty, "wax/" and the robot's name. Each robot needs its own,
    from which its client identifier is made, too."""
    names: bool = False
    """Whether people's names are published: in events, and who drives. Addresses never are."""
    release: bool = False
    """Whether a Stop can be released from there. That moves nothing, but is done without seeing the
    robot."""
    discovery: Annotated[
        str,
        Field(pattern=r"^([A-Za-z0-9_-]+(/[A-Za-z0-9_-]+)*)?$", max_length=100),
        said('empty, or levels of letters, digits, "_" and "-"'),
    ] = "homeassistant"
    """The prefix below which Home Assistant looks for devices; if empty, the robot is not
    announced."""

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        if self.password_file and not self.user:
            raise ValueError("there is a password_file without a user; name who has that password")
        if self.ca_file and not self.url.startswith("mqtts:"):
            raise ValueError("ca_file is for an encrypted connection; write url as mqtts://")
        return self
