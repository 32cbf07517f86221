"""`[[publish]]`: rooms at media servers, where observers watch when the robot is full."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from wax.config.addresses import ONE_URL
from wax.config.allowed import said
from wax.config.table import ConfigTable
from wax.named_file import told_text

_WebSocket = Annotated[
    str,
    Field(pattern=r"^(wss?://[^\s/?#@]+(/[^\s?#]*)?)?$"),
    said('an address as "wss://livekit.example.org", without a user\'s name'),
    ONE_URL,
]
_Http = Annotated[
    str,
    Field(pattern=r"^(https?://[^\s/?#@]+(/[^\s?#]*)?)?$"),
    said('an address as "https://media.example.org", without a user\'s name'),
    ONE_URL,
]


class PublishSettings(ConfigTable):
    """Rooms of a media engine, to which observers are sent when this machine or its upload is full;
    the queue, driving and Stop stay here (config/deploy/README.md). LiveKit keeps a room on one
    of its nodes, so a bigger crowd takes several rooms.
    """

    livekit: _WebSocket = ""
    """LiveKit's address for pages."""
    room: Annotated[str, Field(max_length=64)] = "robot"
    """The room's name."""
    api_key: str = ""
    """LiveKit's API key."""
    api_secret: Annotated[str, Field(repr=False)] = ""
    """The secret of that key, where no file holds it."""
    api_secret_file: str = ""
    """The file that holds the secret of that key."""
    whip: _Http = ""
    """The address of any server that takes WHIP, instead of livekit."""
    whip_token: Annotated[str, Field(repr=False)] = ""
    """The bearer token for whip."""
    watch: _Http = ""
    """The WHIP server's own page, on which people watch."""
    max_viewers: Annotated[int, Field(ge=1, le=100_000)] = 1000
    """The most viewers who are sent to this room."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if bool(self.livekit) == bool(self.whip):
            raise ValueError("name one of livekit and whip: who passes picture and sound on")
        if self.livekit and not (self.api_key and (self.api_secret or self.api_secret_file)):
            raise ValueError("livekit needs api_key, and api_secret or api_secret_file")
        return self

    @property
    def name(self) -> str:
        """The room's name in the log and on the status page."""
        return f"{self.livekit or self.whip} {self.room}" if self.livekit else self.whip

    def secret(self) -> str:
        """Return the secret that signs LiveKit's tokens; raises `StartError`."""
        if not self.api_secret_file:
            return self.api_secret
        holds = "; it holds the secret of LiveKit's api_key"
        return told_text("publish.api_secret_file", self.api_secret_file, holds)
