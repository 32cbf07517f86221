"""`[relay]`: the TURN server."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from wax.config.addresses import TurnUrl
from wax.config.table import ConfigTable


class RelaySettings(ConfigTable):
    """`[relay]`: a TURN server for viewers whose network blocks UDP; none by default."""

    urls: Annotated[list[TurnUrl], Field(max_length=4)] = []
    secret: Annotated[str, Field(repr=False)] = ""
    secret_file: str = ""
    only: bool = False

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
