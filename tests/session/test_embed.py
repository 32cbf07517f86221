"""An embed: a page in another site's frame watches, takes its own share, and does nothing else."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

import pytest
from tests.session.rig import OFFER, FakePeer, Rig, switching
from tests.visitors import visitor

from wax.access.admission import Visitor
from wax.access.host_decisions import HostDecisions
from wax.errors import NoPlaceError
from wax.protocol import messages
from wax.protocol.host_switches import SWITCHES

if TYPE_CHECKING:
    from pydantic import BaseModel

ASKED: list[dict[str, Any]] = [
    *map(switching, SWITCHES.values()),
    {"type": "name", "name": "Eve"},
    {"type": "join"},
    {"type": "leave"},
    {"type": "here"},
    {"type": "stop"},
    {"type": "release", "stop": 0, "sent_server_ms": 0.0, "beat": None},
    {"type": "look", "large": None, "small": True},
    {"type": "keep_tape"},
    {"type": "task", "turn": 1, "text": "to the red post"},
    {"type": "disown", "turn": 1},
    {"type": "follow"},
    {"type": "end_turn", "turn": 1},
    {"type": "remove", "viewer": 1, "ban": True},
    {"type": "mute", "viewer": 1, "muted": True},
    {"type": "mute_address", "presser": 1, "muted": True},
    {"type": "announce", "text": "Hello."},
    {"type": "invite", "purpose": "queue", "uses": 1, "valid_s": 3600},
    {"type": "sign_out_others"},
]
"""One of each message of the state channel that does more than watch."""


@pytest.fixture
def rig() -> Rig:
    camera = {"name": "Arm", "source": "testcard"}
    controls = [{"name": "lamp", "kind": "toggle", "moves": False, "roles": ["observer"]}]
    return Rig({"server": {"max_viewers": 9}, "camera": [camera], "controls": controls})


async def embeds(rig: Rig, number: int) -> FakePeer:
    """Open an embed of somebody new, at an address of their own."""
    who = Visitor(f"embed {number}", f"198.51.100.{number}", is_embed=True)
    await rig.room.answer(who, f"tab-{number}", OFFER)
    FakePeer.made[-1].open()
    FakePeer.made[-1].pings()
    return FakePeer.made[-1]


def _type(message: type[BaseModel]) -> str:
    return str(get_args(message.model_fields["type"].annotation)[0])


async def test_an_embed_can_do_nothing_but_watch(rig: Rig) -> None:
    """Whatever its page sends is refused: robot, queue, Stop and admission stay as they are."""
    known = {_type(one) for one in get_args(messages.StateIn)}
    assert known - {asked["type"] for asked in ASKED} == {"want", "received"}
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.3, ada)
    embed = await embeds(rig, 1)
    rig.wait(1.0, ada, embed)
    told, before = list(rig.robot.told), rig.room.snapshot(rig.clock.time_s)
    for asked in ASKED:
        embed.says(**asked)
        rig.wait(0.1, ada, embed)
    rig.drive(embed, 1, linear=0.5)
    now_ms = rig.clock.time_s * 1000
    row = ["operate", 1, before.turn.number, now_ms, {}, {"lamp": 1}, embed.beat]
    embed.events.received("drive", json.dumps(row))
    rig.wait(0.3, ada, embed)
    assert rig.counters.snapshot()["messages not allowed"] == len(ASKED) + 2
    assert "messages refused" not in rig.counters.snapshot()
    after = rig.room.snapshot(rig.clock.time_s)
    assert (after.stop, after.turn.number) == (None, before.turn.number)
    assert [(one.name, one.role, one.host) for one in after.viewers] == [
        ("Guest 1", "operator", False),
        ("Guest 2", "observer", False),
    ]
    assert rig.decisions == HostDecisions()
    assert rig.access.is_open
    assert set(rig.robot.told[len(told) :]) <= set(told), "the robot was told nothing new"


async def test_an_embed_is_offered_only_watching(rig: Rig) -> None:
    """It has only the driving view, with a stranger's budget, and may choose its streams."""
    embed = await embeds(rig, 1)
    hello = embed.last("hello")
    assert (hello["cameras"], hello["controls"], hello["voice"]) == ([], [], None)
    assert (hello["is_host"], hello["may_queue"]) == (False, True)  # of the page that it leads to
    one = next(iter(rig.viewers))
    assert not rig.room._entry._is_trusted(one)
    embed.says(type="want", sound=False, picture=False, size=hello["sizes"][0], policy=None)
    rig.wait(0.1, embed)
    assert not one.wants_picture


async def test_an_embed_has_no_role_by_http(rig: Rig) -> None:
    """An embed has no role by HTTP, and watching in one makes nobody known to Stop's limits."""
    await embeds(rig, 1)
    rig.wait(0.1)
    assert rig.room.role_of(visitor("")) == "stranger"
    assert rig.room._presence.watches_from("198.51.100.1") == {}
    assert not rig.room.has_people_at("198.51.100.1")


async def test_all_embeds_together_have_a_share_of_the_places(rig: Rig) -> None:
    """They share a quarter, and the next is told when to retry; guests get all other places."""
    first = await embeds(rig, 1)
    await embeds(rig, 2)
    with pytest.raises(NoPlaceError, match="on other sites") as refused:
        await embeds(rig, 3)
    assert refused.value.retry_after_s == 60
    second = await embeds(rig, 1)
    assert not first.is_alive, "the same frame comes back to its own place"
    for number in range(8):
        rig.clock.time_s += 1.0
        guest = replace(visitor(f"guest-{number}"), address=f"192.0.2.{number}")
        await rig.room.answer(guest, "tab-1111", OFFER)
        FakePeer.made[-1].open()
    assert len(rig.names()) == 9
    assert second.last("ended")["text"]["code"] == "door.embeds_full"


async def test_an_embed_leaves_a_narrow_upload_to_guests() -> None:
    """When the upload carries no more, the oldest embed is sent away with the reason."""
    narrow = Rig({"network": {"upload_bps": 60_000}})
    first = await embeds(narrow, 1)
    with pytest.raises(NoPlaceError, match="carries no more"):
        await embeds(narrow, 2)
    await narrow.enter("ada-1111")
    assert first.last("ended")["text"]["code"] == "door.embeds_full"
    assert narrow.names() == ["Guest 2"]


async def test_an_embed_never_drives_even_where_everybody_queues() -> None:
    """Even where every newcomer gets a place in the queue, an embed gets none."""
    rig = Rig({"turns": {"join": "auto"}})
    embed = await embeds(rig, 1)
    rig.wait(0.5, embed)
    assert rig.room.snapshot(rig.clock.time_s).turn.operator is None
    ada = await rig.enter("ada-1111")
    rig.wait(0.5, embed, ada)
    assert rig.room.snapshot(rig.clock.time_s).turn.operator == ada.last("hello")["viewer"]


async def test_an_embed_is_sent_away_as_strangers_are(rig: Rig) -> None:
    """When the host closes, an embed ends as every other page does."""
    embed = await embeds(rig, 1)
    rig.access.close(True)
    rig.wait(1.1, embed)
    assert embed.last("ended")["text"]
    assert rig.names() == []
