"""What a program that follows is told of what operators do."""

from __future__ import annotations

from typing import Any

from tests.session.rig import Rig

from wax.session.followers import MOST

SPEEDS = {"linear_mps", "lateral_mps", "angular_rps"}
FIELDS = {"type", "server_ms", "turn", "reason", "limit"} | SPEEDS


def driven(rig: Rig, peer: Any) -> list[dict[str, Any]]:
    return [one for one in peer.sent if one["type"] == "driven"]


async def test_a_follower_gets_each_set_point_once() -> None:
    """While somebody drives and when the robot is held; others get none."""
    rig = Rig({})
    ada, eve = await rig.enter("ada-1111"), await rig.enter("eve-1111")
    eve.says(type="follow")
    ada.says(type="join")
    rig.wait(0.3, ada, eve)
    for seq in range(1, 12):
        rig.drive(ada, seq, linear=0.0 if seq < 3 else 0.5)
        rig.wait(0.1, ada, eve)
    told = driven(rig, eve)
    assert set(told[-1]) == FIELDS, "no name and no address"
    assert told[-1]["linear_mps"] > 0
    assert told[-1]["reason"] is None
    assert told[-1]["turn"] == 1
    assert [one["server_ms"] for one in told] == sorted({one["server_ms"] for one in told})
    rig.wait(2.0, ada, eve)
    told = driven(rig, eve)
    assert (told[-1]["linear_mps"], told[-1]["reason"]) == (0.0, "lapsed")
    rig.wait(1.0, ada, eve)
    assert driven(rig, eve) == told
    assert driven(rig, ada) == []


async def test_few_may_follow() -> None:
    """Only four programs follow at once; a place is free again when one leaves."""
    rig = Rig({})
    peers = [await rig.enter(f"program-{number}") for number in range(MOST + 1)]
    for one in peers:
        one.says(type="follow")
        one.says(type="follow")
    rig.wait(0.3, *peers)
    assert [bool(driven(rig, one)) for one in peers] == [True] * MOST + [False]
    assert peers[-1].last("notice")["text"] == {"code": "follow.full", "values": {"n": MOST}}
    peers[0].abandon()
    peers[-1].says(type="follow")
    rig.wait(0.3, *peers[1:])
    assert driven(rig, peers[-1])
