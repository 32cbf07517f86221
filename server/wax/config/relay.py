"""`[relay]`: the TURN server."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from wax.config.addresses import TurnUrl
from wax.config.table import ConfigTable


class RelaySettings(ConfigTable):
    """A TURN server (config/deploy/turnserver.conf is one for coturn), which relays for viewers
    whose network lets no UDP out.
    """

    urls: Annotated[list[TurnUrl], Field(max_length=4)] = []
    """Its addresses; with "?transport=tcp" it is reached by TCP, with "turns:" by TLS."""
    secret: Annotated[str, Field(repr=False)] = ""
    """The TURN server's static-auth-secret. Viewers never see it, but get a name and a password
    that expire after ten minutes."""
    secret_file: str = ""
    """A file with that secret, so that it need not stand here."""
    only: bool = False
    """Whether viewers use the relay even where they could connect directly."""

    @model_validator(mode="after")
    def _has_what_it_needs(self) -> Self:
        if self.secret and self.secret_file:
            raise ValueError("there are a secret and a secret_file; leave one of them out")
        if self.urls and not (self.secret or self.secret_file):
            raise ValueError(
                "there are urls without a secret; name the file that holds the TURN server's"
                " static-auth-secret in secret_file"
            )
        if self.only and not self.urls:
            raise ValueError("only = true needs urls, the addresses of a TURN server")
        return self
