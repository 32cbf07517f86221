"""Commands by MQTT."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.access.permissions import may
from wax.house.commands import NAMES, HouseAct, ReleaseAt, parse
from wax.protocol import messages
from wax.protocol.host_switches import Blank, Close, HoldQueue


@pytest.mark.parametrize(
    ("name", "payload", "act"),
    [
        ("stop", b"PRESS", messages.Stop(type="stop")),
        ("stop", b"\xff" * 1000, messages.Stop(type="stop")),
        ("release", b"1764158400000", ReleaseAt(1764158400000)),
        ("open", b"ON", Close(type="close", closed=False)),
        ("open", b"OFF", Close(type="close", closed=True)),
        ("paused", b"ON", HoldQueue(type="hold_queue", held=True)),
        ("blanked", b"OFF", Blank(type="blank", blanked=False)),
        ("release", b"PRESS", None),
        ("release", b"1" * 14, None),
        ("release", "１７６４１５８４０００００".encode(), None),
        ("open", b"on", None),
        ("open", b"ON ", None),
        ("blanked", b"\xff\x00", None),
        ("drive", b"ON", None),
        ("", b"ON", None),
    ],
)
def test_a_message_means_one_thing_or_nothing(
    name: str, payload: bytes, act: HouseAct | None
) -> None:
    """No payload is guessed, except that a Stop counts whatever its payload."""
    assert parse(name, payload) == act


@given(st.sampled_from(NAMES) | st.text(), st.binary() | st.sampled_from([b"ON", b"OFF"]))
def test_whatever_comes_is_within_its_role(name: str, payload: bytes) -> None:
    """No message becomes an act beyond the house's role, and never one that drives."""
    act = parse(name, payload)
    if act is not None:
        assert may("house", messages.Release if isinstance(act, ReleaseAt) else type(act))
