"""What the host's home automation does, in a real room."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel
from tests.session.rig import Rig

from wax.access.permissions import PERMISSIONS, may
from wax.driver.interface import Twist
from wax.errors import ForbiddenError
from wax.house.commands import NAMES, ReleaseAt, parse
from wax.protocol import messages
from wax.protocol.host_switches import Blank, Close, HoldQueue
from wax.session.stop_budget import HOUSE

STOP = messages.Stop(type="stop")


@pytest.fixture
def releasing() -> Rig:
    return Rig({"mqtt": {"release": True}})


async def test_its_stop_works_like_anybodys(rig: Rig) -> None:
    """It is latched before anything else, with its own name and role; the host releases it."""
    bob = await rig.enter("bob-1111")
    rig.heard.take()
    rig.room.house_acts(STOP)
    assert rig.robot.told[-1] == "stop"
    rig.wait(0.3, bob)
    told = messages.StopInfo(number=1, by=HOUSE)
    assert bob.last("room")["stop"] == told.model_dump(mode="json")
    pressed = {"type": "stop.pressed", "stop": 1, "role": "house", "name": None}
    assert pressed in rig.heard.take()
    host = await rig.enter("hedy-111", is_host=True)
    host.says(type="release", stop=1, sent_server_ms=rig.clock.time_s * 1000, beat=host.beat)
    assert rig.loop.latched is None


async def test_it_releases_nothing_unless_configured(rig: Rig) -> None:
    """Its role alone does not permit a release."""
    rig.room.house_acts(STOP)
    with pytest.raises(ForbiddenError, match="Only"):
        rig.room.house_acts(ReleaseAt(0))
    assert rig.loop.latched is not None


async def test_where_configured_it_releases(releasing: Rig) -> None:
    """A release counts as of when it was sent (the wall clock says 0): one held back is late."""
    releasing.room.house_acts(STOP)
    releasing.clock.time_s += 1.0
    for wall_ms, said in ((-5000, "sent 5 s ago.* clock is behind"), (60, "in 0.06 s: .*ahead")):
        with pytest.raises(ForbiddenError, match=said):
            releasing.room.house_acts(ReleaseAt(wall_ms))
    for wall_ms in (-2001, 51):
        with pytest.raises(ForbiddenError):
            releasing.room.house_acts(ReleaseAt(wall_ms))
    releasing.heard.take()
    releasing.room.house_acts(ReleaseAt(0))
    assert releasing.loop.latched is None
    assert [(one["type"], one["role"]) for one in releasing.heard.take()] == [
        ("stop.released", "house")
    ]
    with pytest.raises(ForbiddenError):
        releasing.room.house_acts(ReleaseAt(0))


async def test_a_press_after_the_release_was_sent_lasts(releasing: Rig) -> None:
    """So does the host's own press, which only the host releases."""
    releasing.room.house_acts(STOP)
    with pytest.raises(ForbiddenError):
        releasing.room.house_acts(ReleaseAt(-1))
    host = await releasing.enter("hedy-111", is_host=True)
    host.says(type="stop")
    with pytest.raises(ForbiddenError):
        releasing.room.house_acts(ReleaseAt(0))
    assert releasing.loop.latched is not None


async def test_it_closes_pauses_and_blanks(rig: Rig) -> None:
    """It acts at once, as the host would."""
    bob = await rig.enter("bob-1111")
    rig.room.house_acts(HoldQueue(type="hold_queue", held=True))
    rig.room.house_acts(Blank(type="blank", blanked=True))
    rig.wait(0.3, bob)
    told = bob.last("room")["host_settings"]
    assert (told["held"], told["blanked"]) == (True, True)
    rig.room.house_acts(Close(type="close", closed=True))
    assert bob.last("ended")["openings"] == []
    assert not rig.access.is_open
    rig.room.house_acts(Close(type="close", closed=False))
    assert rig.access.is_open


OTHERS = [
    act.model_construct()
    for act in PERMISSIONS
    if not isinstance(act, str) and issubclass(act, BaseModel) and not may("house", act)
]
SAID = st.tuples(
    st.sampled_from(NAMES), st.sampled_from([b"ON", b"OFF", b"0000000000000"]) | st.binary()
).map(lambda said: parse(*said))


@given(st.booleans(), st.lists(SAID | st.sampled_from(OTHERS), max_size=20))
def test_nothing_it_says_drives(releases: bool, said: list[Any]) -> None:
    """In any mix of acts no turn begins, nothing moves, and a Stop lasts unless releasing is
    configured.
    """
    one = Rig({"mqtt": {"release": releases}})
    is_stopped = False
    for act in filter(None, said):
        kind = messages.Release if isinstance(act, ReleaseAt) else type(act)
        try:
            one.room.house_acts(act)
        except ForbiddenError:
            assert kind is messages.Release or not may("house", kind)
        else:
            assert may("house", kind)
            is_stopped |= kind is messages.Stop
        one.wait(0.1)
        assert releases or (one.loop.latched is not None) is is_stopped
    assert one.room.snapshot(one.clock.time_s).turn.operator is None
    assert all(told in ("stop", Twist(0.0, 0.0)) for told in one.robot.told)
