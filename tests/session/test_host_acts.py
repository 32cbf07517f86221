"""What the host does on their page, in a real room."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs
from tests.session.rig import OFFER, Rig, switching
from tests.visitors import TAB, visitor

from wax.access.access import Shown
from wax.access.admission import BANNED, LOCKED
from wax.access.host_decisions import BLANKED
from wax.access.host_secrets import OVERLAP_S
from wax.errors import NotAdmittedError
from wax.protocol.host_switches import SWITCHES, HostSettings, HostSwitches
from wax.session.host_acts import REMOVED

if TYPE_CHECKING:
    from tests.session.rig import FakePeer

    from wax.protocol.host_switches import HostSwitch


@pytest.fixture
async def host(rig: Rig) -> FakePeer:
    return await rig.enter("hedy-111", is_host=True)


async def test_the_host_sees_who_is_here(rig: Rig, host: FakePeer) -> None:
    """Only the host is sent addresses, and those shortened."""
    bob = await rig.enter("bob-1111")
    rig.wait(1.2, host, bob)
    told = host.last("console")
    assert [line["address"] for line in told["viewers"]] == ["192.0.2.0/24"] * 2
    assert (told["closed"], told["opens_wall_ms"]) == (False, None)
    assert "console" not in {one["type"] for one in bob.sent}
    assert [line["host"] for line in bob.last("room")["viewers"]] == [True, False]


async def test_the_host_reads_that_the_machine_is_too_busy(rig: Rig, host: FakePeer) -> None:
    """While observers are sent less because the event loop is late, the host's page says so."""
    rig.parts.pipelines.service.relieve(0.03)
    rig.wait(1.2, host)
    assert [one["code"] for one in host.last("console")["problems"]] == ["busy.loop"]


@pytest.mark.parametrize("switch", SWITCHES.values(), ids=lambda one: one.kept)
async def test_a_switch_is_one_record(rig: Rig, host: FakePeer, switch: HostSwitch) -> None:
    """What the host switches is told to pages by its name there, and logged."""
    act = switching(switch)
    with capture_logs() as logs:
        host.says(**act)
    rig.wait(0.3, host)
    changed = HostSwitches().after(switch.act.model_validate(act))
    assert rig.decisions.switches == changed != HostSwitches()
    told = {switch.told: act[switch.field]} if switch.told else {}
    assert host.last("room")["host_settings"] == HostSettings().model_dump() | told
    [logged] = [line for line in logs if line["event"] == "host's act"]
    assert logged["act"] == act["type"]


async def test_a_held_queue_waits(rig: Rig, host: FakePeer) -> None:
    """No turn begins until the host resumes it."""
    host.says(type="hold_queue", held=True)
    bob = await rig.enter("bob-1111")
    bob.says(type="join")
    rig.wait(0.3, host, bob)
    assert bob.last("room")["host_settings"]["held"]
    assert bob.last("room")["turn"]["operator"] is None
    host.says(type="hold_queue", held=False)
    rig.wait(0.3, host, bob)
    assert bob.last("room")["turn"]["operator"] == 2


async def test_the_host_ends_only_the_turn_that_was_meant(rig: Rig, host: FakePeer) -> None:
    """A late click ends nobody else's turn."""
    bob = await rig.enter("bob-1111")
    bob.says(type="join")
    rig.wait(0.3, host, bob)
    host.says(type="end_turn", turn=0)
    rig.wait(0.3, host, bob)
    assert bob.last("room")["turn"]["operator"] == 2
    host.says(type="end_turn", turn=1)
    rig.wait(0.3, host, bob)
    assert bob.last("room")["turn"]["operator"] is None
    assert bob.last("notice")["text"] == {"code": "turn.ended"}


@pytest.mark.parametrize("ban", [False, True])
async def test_a_troll_is_removed(rig: Rig, host: FakePeer, ban: bool) -> None:
    """Their tabs end with a sentence; with a ban neither they nor their address come back."""
    troll = await rig.enter("troll-11")
    host.says(type="remove", viewer=2, ban=ban)
    assert troll.last("ended")["text"] == (BANNED if ban else REMOVED).wire()
    assert rig.names() == ["Guest 1"]
    event = "viewer.banned" if ban else "viewer.removed"
    assert {"type": event, "viewer": 2, "name": "Guest 2"} in rig.heard.take()
    if not ban:
        await rig.enter("troll-11")
        return
    for back in (visitor("troll-11", address="198.51.100.1"), visitor("new-1111")):
        with pytest.raises(NotAdmittedError, match=str(BANNED)):
            await rig.room.answer(back, TAB, OFFER)
    [ban_kept] = rig.access.admission._bans
    assert (ban_kept.identity, ban_kept.address) == ("troll-11", "192.0.2.1")


async def test_a_host_removes_no_host(rig: Rig, host: FakePeer) -> None:
    """Not even themselves."""
    host.says(type="remove", viewer=1, ban=True)
    assert host.last("notice")["text"] == {"code": "host.stays"}
    assert rig.names() == ["Guest 1"]


async def test_one_press_locks(rig: Rig, host: FakePeer) -> None:
    """Strangers are sent away at once and stay out; invited guests stay."""
    await rig.enter("troll-11")
    token, _ = rig.access.invite("queue", uses=1, valid_s=600)
    rig.access.enter(token, "friend-1")
    friend = await rig.enter("friend-1")
    host.says(type="lock", locked=True)
    assert rig.names() == ["Guest 1", "Guest 3"]
    rig.wait(0.3, host, friend)
    assert friend.last("room")["host_settings"]["locked"]
    with pytest.raises(NotAdmittedError, match=str(LOCKED)):
        await rig.room.answer(visitor("new-1111"), TAB, OFFER)


async def test_a_muted_viewer_stops_nothing(rig: Rig, host: FakePeer) -> None:
    """Their Stop stops nothing until the host unmutes them."""
    bob = await rig.enter("bob-1111")
    host.says(type="mute", viewer=2, muted=True)
    bob.says(type="stop")
    assert rig.loop.latched is None
    host.says(type="mute", viewer=2, muted=False)
    bob.says(type="stop")
    assert rig.loop.latched is not None


async def test_while_blanked_nobody_drives(rig: Rig, host: FakePeer) -> None:
    """The robot stays stopped, and everybody reads why."""
    bob = await rig.enter("bob-1111")
    bob.says(type="join")
    rig.wait(0.3, host, bob)
    host.says(type="blank", blanked=True)
    for seq, linear in enumerate((0.0, 1.0), start=1):
        rig.drive(bob, seq, linear=linear)
        rig.wait(0.1, host, bob)
    rig.wait(0.4, host, bob)
    assert bob.last("room")["host_settings"]["blanked"]
    assert bob.last("drive_status") | {"type": ""} == {
        "type": "",
        "moving": False,
        "reason": BLANKED.wire(),
        "share": 0.0,
    }
    assert bob.last("room")["turn"]["stands_left_ms"] is not None


async def test_the_hosts_limit_is_for_guests(rig: Rig, host: FakePeer) -> None:
    """The host's own pages may use the robot's full speed."""
    await rig.enter("bob-1111")
    host.says(type="limit_speed", fraction=0.25)
    assert (rig.viewers.max_fraction(2), rig.viewers.max_fraction(1)) == (0.25, 1.0)


async def test_an_announcement_is_one_bounded_line(rig: Rig, host: FakePeer) -> None:
    """Everybody reads it, without characters that reverse the text."""
    host.says(type="announce", text="  Hello \u202e all ")
    rig.wait(0.3, host)
    assert host.last("room")["host_settings"]["message"] == "Hello \\u202e all"


async def test_an_announcement_expires(rig: Rig, host: FakePeer) -> None:
    """It ends when the host said, which everybody is told; one without an end stays."""
    host.says(type="announce", text="Back soon", for_s=2)
    ends_s = rig.clock.now_s() + 2
    rig.wait(0.3, host)
    told = host.last("room")["host_settings"]
    assert (told["message"], told["message_ends_server_ms"]) == ("Back soon", ends_s * 1000)
    rig.wait(2.0, host)
    told = host.last("room")["host_settings"]
    assert (told["message"], told["message_ends_server_ms"]) == ("", None)
    host.says(type="announce", text="Tea")
    rig.wait(5.0, host)
    assert host.last("room")["host_settings"]["message"] == "Tea"


async def test_an_invitation_reaches_the_host_alone(rig: Rig, host: FakePeer) -> None:
    """Only the host reads the link, which works as its purpose says."""
    host.says(type="invite", purpose="watch", uses=2, valid_s=600)
    link = host.last("invitation")
    assert link["page"] == "https://robot.example.org"
    assert rig.access.enter(link["token"], "friend-1").purpose == "watch"


async def test_closed_for_the_day(rig: Rig, host: FakePeer) -> None:
    """Guests leave, and come in again once the host opens."""
    bob = await rig.enter("bob-1111")
    host.says(type="close", closed=True)
    assert bob.last("ended")["openings"] == []
    rig.wait(1.2, host)
    assert host.last("console")["closed"]
    host.says(type="close", closed=False)
    await rig.enter("bob-1111")


async def test_the_others_are_signed_out(rig: Rig, host: FakePeer) -> None:
    """All their pages end at once; the host who asked stays, and so do guests."""
    thief, bob = await rig.enter("thief-11", is_host=True), await rig.enter("bob-1111")
    thief.says(type="name", name="Host")
    host.says(type="sign_out_others")
    assert thief.last("ended")["text"] == {"code": "host.signed_out"}
    thief.says(type="lock", locked=True)
    assert host.last("notice")["text"] == {
        "code": "host.signed_out_others",
        "values": {"n": 1},
    }
    rig.wait(1.2, host, bob)
    assert rig.names() == ["Guest 1", "Guest 3"]
    assert not rig.decisions.switches.is_locked


async def test_the_host_reads_that_an_old_cookie_is_used(
    rig: Rig, host: FakePeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The host reads from where, until they have signed out the others."""
    cookie = rig.access.become_host(rig.access.new_host_link())
    rig.access.renew_cookie(Shown(host=cookie))
    rig.wait(1.2, host)
    assert host.last("console")["reused"] is None
    monkeypatch.setattr(rig.clock, "wall_ms", lambda: round(OVERLAP_S * 1000))
    assert not rig.access.visitor(Shown(host=cookie), "198.51.100.7").is_host
    rig.wait(1.2, host)
    assert host.last("console")["reused"] == "198.51.100.0/24"
    host.says(type="sign_out_others")
    rig.wait(1.2, host)
    assert host.last("console")["reused"] is None


async def test_the_host_sees_and_ignores_an_address_that_presses(rig: Rig, host: FakePeer) -> None:
    """The host sees the last name and the number of presses; ignored, they stop nothing."""
    bob = await rig.enter("bob-1111")
    bob.says(type="stop")
    rig.wait(1.2, host, bob)
    [presser] = host.last("console")["pressers"]
    assert presser == {
        "id": presser["id"],
        "address": "192.0.2.0/24",
        "by": {"code": "by.named", "values": {"name": "Guest 2"}},
        "presses": 1,
        "muted": False,
    }
    host.says(type="mute_address", presser=presser["id"], muted=True)
    host.says(type="release", stop=1, sent_server_ms=rig.clock.time_s * 1000, beat=host.beat)
    bob.says(type="stop")
    assert bob.last("notice")["text"] == {"code": "stop.muted"}
    assert rig.loop.latched is None
    rig.wait(1.2, host, bob)
    assert host.last("console")["pressers"][0]["muted"]


async def test_guests_cannot_act_as_the_host(rig: Rig, host: FakePeer) -> None:
    """An observer who sends the host's messages reads that they may not."""
    bob = await rig.enter("bob-1111")
    for act in (
        {"type": "hold_queue", "held": True},
        {"type": "lock", "locked": True},
        {"type": "remove", "viewer": 1, "ban": True},
        {"type": "blank", "blanked": True},
        {"type": "mute_address", "presser": 1, "muted": True},
        {"type": "sign_out_others"},
    ):
        bob.says(**act)
        assert bob.last("notice")["text"] == {"code": "may.host"}
    assert rig.names() == ["Guest 1", "Guest 2"]
    assert not rig.decisions.switches.is_blanked
