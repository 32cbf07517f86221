"""What a crowd watches, and its answers, each a line of JSON."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel

from wax.client.media import RtcpAnswers, StreamCounts


@dataclass(frozen=True, slots=True)
class Offering:
    """A server: ours, one that takes offers at ``/offer`` and has no data channels, or Janus."""

    url: str
    how: Literal["wax", "stock", "janus"]


class ViewerCounts(BaseModel):
    """What one viewer has received and sent back since it joined."""

    video: StreamCounts
    audio: StreamCounts
    answers: RtcpAnswers


class Sample(BaseModel):
    """All viewers at one moment of `time.monotonic`; `problem` says why a request failed."""

    at_s: float
    viewers: tuple[ViewerCounts, ...] = ()
    problem: str | None = None
