"""What all messages have in common."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Incoming(BaseModel):
    """A message, or a part of one, from a page."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class Outgoing(BaseModel):
    """A message, or a part of one, to pages."""

    model_config = ConfigDict(frozen=True)
