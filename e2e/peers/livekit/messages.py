"""The peer's messages on standard output, one JSON object a line."""

from __future__ import annotations

from typing import Final

from pydantic import BaseModel, ConfigDict, TypeAdapter


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Ready(_Message):
    """All parts work; `url` is the page's."""

    url: str
    server_version: str
    client_version: str


class Refusal(_Message):
    """It cannot work, and this sentence says why; the process ends."""

    refused: str


FIRST_LINE: Final[TypeAdapter[Ready | Refusal]] = TypeAdapter(Ready | Refusal)


def say(message: BaseModel) -> None:
    print(message.model_dump_json(), flush=True)
