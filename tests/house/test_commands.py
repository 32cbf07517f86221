"""Commands by MQTT."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.access.permissions import PERMISSIONS, may
from wax.house.commands import NAMES, HouseAct, ReleaseAt, parse
from wax.protocol import messages

MAY = {messages.Stop, messages.Release, messages.HoldQueue, messages.Close, messages.Blank}


@pytest.mark.parametrize(
    ("name", "payload", "act"),
    [
        ("stop", b"PRESS", messages.Stop(type="stop")),
        ("stop", b"\xff" * 1000, messages.Stop(type="stop")),
        ("release", b"1764158400000", ReleaseAt(1764158400000)),
        ("open", b"ON", messages.Close(type="close", closed=False)),
        ("open", b"OFF", messages.Close(type="close", closed=True)),
        ("paused", b"ON", messages.HoldQueue(type="hold_queue", held=True)),
        ("blanked", b"OFF", messages.Blank(type="blank", blanked=False)),
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


def test_the_house_may_do_five_things() -> None:
    """The house's role permits five acts: no driving, no page, none of the host's others."""
    assert {act for act in PERMISSIONS if may("house", act)} == MAY
