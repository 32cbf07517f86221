"""Incoming MQTT: a topic's name and its payload, whoever may publish there."""

from __future__ import annotations

from typing import Final

from tests.fuzz.target import Target

from wax.access.permissions import may
from wax.house.commands import ReleaseAt, parse
from wax.protocol import messages


def _hear(data: bytes) -> None:
    name, _, payload = data.partition(b"/")
    act = parse(name.decode("utf-8", "replace"), payload)
    kind = messages.Release if isinstance(act, ReleaseAt) else type(act)
    assert act is None or may("house", kind), "the house did what it may not"


HOUSE: Final = Target(
    name="house",
    what="messages by MQTT",
    hear=_hear,
    seeds=(b"stop/PRESS", b"open/OFF", b"paused/ON", b"blanked/OFF", b"release/1764158400000"),
    words=(b"stop/", b"release/", b"open/", b"ON", b"OFF", b"\xff", b"9" * 13),
    max_bytes=1024,
)
