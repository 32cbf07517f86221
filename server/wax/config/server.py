"""`[server]`: where the page is served, and to how many."""

from __future__ import annotations

from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import Field, model_validator

from wax.config.addresses import ONE_HOST, HostName, Network, PageUrl
from wax.config.table import ConfigTable


class ServerSettings(ConfigTable):
    """`[server]`: where the page is served, and to how many viewers."""

    host: Annotated[str, Field(min_length=1), ONE_HOST] = "localhost"
    port: Annotated[int, Field(ge=0, le=65535)] = 8080
    max_viewers: Annotated[int, Field(ge=1, le=1000)] = 100
    state_dir: str = ""
    max_share_per_address: Annotated[float, Field(gt=0, le=1)] = 0.5
    max_offers_per_address_hz: Annotated[float, Field(gt=0, le=1000)] = 2.0
    max_silent_per_address: Annotated[int, Field(ge=1, le=1000)] = 2
    names: list[HostName] = []
    public_url: PageUrl = ""
    trusted_proxies: list[Network] = []
    https: bool = False
    certificate: str = ""
    key: str = ""
    max_connections: Annotated[int, Field(ge=16, le=100_000)] = 640
    max_connections_per_address: Annotated[int, Field(ge=4, le=100_000)] = 64

    @property
    def all_names(self) -> list[str]:
        """`names`, and that of the public page."""
        public = urlsplit(self.public_url).hostname
        return [*self.names, *([public] if public else [])]

    @model_validator(mode="after")
    def _certificate_has_its_key(self) -> Self:
        if bool(self.certificate) != bool(self.key):
            missing = "key" if self.certificate else "certificate"
            raise ValueError(f"certificate and key belong together; {missing} is missing")
        return self
