"""The room: who is here, lost or forgotten, and what everybody is told."""

from __future__ import annotations

import asyncio
import gc
import json
import math
import weakref
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import pytest
from tests.session.rig import OFFER, FakePeer, Rig, Robot
from tests.visitors import TAB, visitor

from wax.access.admission import CLOSED
from wax.control.reasons import ABOARD
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import (
    STANDSTILL,
    Aboard,
    Limits,
    OwnView,
    Twist,
)
from wax.errors import ForbiddenError, FullError, NoPlaceError, SignallingError
from wax.fanout.batches import PORTION
from wax.protocol import messages
from wax.sentence import Sentence, says
from wax.session import presence
from wax.session import room as room_module
from wax.session.room import Room

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.rtc.peer import Peer
    from wax.session.tape_keeper import TapeKeeper


@pytest.mark.parametrize(
    ("viewers", "waits_s"),
    [([], None), ([(True, None)], None), ([(True, 0.5), (True, 2.0)], 2.0), ([(False, 2.0)], None)],
)
def test_a_file_waits_for_the_links_of_its_browser(
    viewers: list[tuple[bool, float | None]], waits_s: float | None
) -> None:
    """The slowest connected link decides how long the file waits."""
    own = [
        SimpleNamespace(
            peer=object() if has_peer else None,
            streams=SimpleNamespace(file_sent=lambda _size, found=found: found),
        )
        for has_peer, found in viewers
    ]
    room = SimpleNamespace(_viewers=SimpleNamespace(of_identity=lambda _who: own))
    assert Room.file_sent(cast("Room", room), visitor("somebody"), 200) == waits_s


async def test_a_newcomer_is_greeted_and_gets_the_room(rig: Rig) -> None:
    """The first message says who they are and what the robot can do; then comes the room."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.1, ada)
    hello, told = ada.last("hello"), ada.last("room")
    assert hello["robot"]["axes"] == ["pan"]
    assert "max_lateral_mps" not in hello["robot"]
    assert hello["on_loss"]["silence_ms"] is None  # this driver has no process of its own
    assert hello["on_loss"]["robot_ttl_ms"] is None
    assert [line["id"] for line in told["viewers"]] == [hello["viewer"]]
    assert hello["has_microphone"] is False
    assert told["audio"]["problem"] is None
    assert told["video"]["problem"] is None


async def test_everybody_is_told_that_nobody_new_can_come(rig: Rig) -> None:
    """Everybody is told while it lasts, but only the host reads why."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.1, ada)
    assert ada.last("room")["no_way_in"] is None
    rig.tunnel.problem = Sentence("door.goodbye")
    rig.wait(2, ada)
    assert ada.last("room")["no_way_in"] == {"code": "tunnel.nobody_new"}
    rig.tunnel.problem = None
    rig.wait(2, ada)
    assert ada.last("room")["no_way_in"] is None


async def test_a_newcomer_reads_whose_robot_this_is() -> None:
    """Name, sentence, rules and links come as the host wrote them."""
    link = {"text": "Us", "url": "https://example.org/us"}
    page = {"name": "Rover", "sentence": "Say hello.", "rules": ["Slowly."], "links": [link]}
    ada = await Rig({"page": page}).enter("ada-1111")
    assert ada.last("hello")["page"] == page


async def test_a_newcomer_is_told_how_the_camera_sees_the_floor() -> None:
    """The greeting has the host's measurements, or none."""
    ada = await Rig({}).enter("ada-1111")
    robot = ada.last("hello")["robot"]
    assert (robot["camera"], robot["width_m"]) == (None, None)
    assert "camera_stereo" not in robot
    assert robot["motion"]["braking_mps2"] == 2.0
    video = {"camera_height_m": 0.3, "camera_tilt_deg": 12.5, "camera_fov_deg": 70.0}
    video["camera_stereo"] = True
    eve = await Rig({"video": video, "robot": {"width_m": 0.25}}).enter("eve-1111")
    robot = eve.last("hello")["robot"]
    assert robot["camera"] == {"height_m": 0.3, "tilt_deg": 12.5, "fov_deg": 70.0, "axis_row": 0.5}
    assert (robot["width_m"], robot["camera_stereo"]) == (0.25, True)


async def test_a_newcomer_is_told_of_a_robot_that_moves_sideways(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The greeting says how fast it does, and only then the key is there at all."""
    monkeypatch.setattr(Robot, "limits", Limits(1.0, 2.0, ("pan",), lateral_mps=0.5))
    ada = await Rig({}).enter("ada-1111")
    assert ada.last("hello")["robot"]["max_lateral_mps"] == 0.5


async def test_a_robots_own_view_is_not_sent_for_a_turned_picture(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A path drawn by the robot's own view would be wrong on a picture that the host has turned."""
    monkeypatch.setattr(Robot, "own_view", OwnView(0.3, 10.0, 60.0, 0.4), raising=False)
    for keys, known in (({}, True), ({"rotate": 180}, False), ({"mirror": True}, False)):
        ada = await Rig({"video": {"source": "robot", **keys}}).enter("ada-1111")
        assert (ada.last("hello")["robot"]["camera"] is not None) is known


@pytest.mark.parametrize("soft", [False, True])
async def test_a_newcomer_is_told_whether_the_robot_brakes_softly(soft: bool) -> None:
    """The greeting has what is configured."""
    rig = Rig({"robot": {"soft_braking": soft}})
    ada = await rig.enter("ada-1111")
    assert ada.last("hello")["on_loss"]["soft_braking"] is soft


@pytest.mark.parametrize(("drive", "may"), [({}, False), ({"click_to_move": True}, True)])
async def test_a_newcomer_is_told_whether_clicks_may_move_the_robot(
    drive: dict[str, bool], may: bool
) -> None:
    """They may not unless the host has allowed it."""
    rig = Rig({"drive": drive})
    ada = await rig.enter("ada-1111")
    assert ada.last("hello")["click_to_move"] is may


@pytest.mark.parametrize(("beyond_s", "moves"), [(-0.2, True), (0.2, False)])
async def test_a_held_button_drives_on_after_a_short_lapse(
    rig: Rig, beyond_s: float, moves: bool
) -> None:
    """Commands that resume sooner move the robot without a new press, later ones do not."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.3, ada)
    for seq, linear in enumerate((0.0, 0.5), 1):
        rig.drive(ada, seq, linear=linear)
        rig.wait(0.1, ada)
    rig.wait(ada.last("hello")["on_loss"]["resume_within_ms"] / 1000 + beyond_s, ada)
    assert not ada.last("drive_status")["moving"]
    rig.drive(ada, 3, linear=0.5)
    rig.wait(0.1, ada)
    assert ada.last("drive_status")["moving"] is moves


async def test_an_operator_in_another_network_drives_on_by_a_new_press(rig: Rig) -> None:
    """The robot stops at once, and a button held meanwhile moves nothing; they keep the turn."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.3, ada, bob)

    def moves(seq: int, linear: float) -> bool:
        rig.drive(ada, seq, linear=linear)
        rig.wait(0.1, ada, bob)
        newest = rig.robot.told[-1]
        return isinstance(newest, Twist) and newest != Twist()

    assert [moves(1, 0.0), moves(2, 0.5)] == [False, True]
    bob.events.network_changed()
    assert moves(3, 0.5)
    ada.events.network_changed()
    assert rig.robot.told[-1] == "stop"
    assert [moves(4, 0.5), moves(5, 0.5), moves(6, 0.0), moves(7, 0.5)] == [False] * 3 + [True]
    turn = ada.last("room")["turn"]
    assert (turn["number"], turn["operator"]) == (1, 1)


async def test_the_same_page_gets_its_place_back(rig: Rig) -> None:
    """A page that reloads is the same viewer: it keeps name, place and turn."""
    ada = await rig.enter("ada-1111")
    ada.says(type="name", name="Ada")
    ada.says(type="join")
    rig.wait(0.2, ada)
    again = await rig.enter("ada-1111")
    rig.wait(0.2, again)
    (line,) = again.last("room")["viewers"]
    assert (line["name"], line["role"], line["lost"]) == ("Ada", "operator", False)
    assert not ada.is_alive
    assert again.last("room")["turn"]["number"] == 1


async def test_an_old_peer_that_ends_late_takes_nothing_with_it(rig: Rig) -> None:
    """A reload whose old connection is still closing when the new one opens loses nothing."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    ada.is_alive = False  # it closes by itself, and has not said so yet
    again = await rig.enter("ada-1111")
    ada.events.closed(cast("Peer", ada))
    rig.wait(4.0, again)
    assert again.is_alive
    assert [line["role"] for line in again.last("room")["viewers"]] == ["operator"]


async def test_newcomers_learn_of_themselves_at_once(rig: Rig) -> None:
    """A newcomer can join before the others are told of them."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.1, ada)
    bob = await rig.enter("bob-1111")
    assert [line["id"] for line in bob.last("room")["viewers"]] == [1, 2]
    assert [line["id"] for line in ada.last("room")["viewers"]] == [1]


async def test_a_server_that_ends_says_goodbye(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every page is told before its peer closes, and nobody else is admitted."""
    monkeypatch.setattr(presence, "_GOODBYE_S", 0.0)
    ada, bob = await rig.enter("client-ada"), await rig.enter("client-bob")
    await rig.room.close()
    for peer in (ada, bob):
        assert peer.sent[-1]["text"] == {"code": "door.goodbye"}
        assert (peer.sent[-1]["type"], peer.is_alive) == ("goodbye", False)
    with pytest.raises(FullError, match="restarting"):
        await rig.enter("client-eve")


async def test_a_viewer_who_is_gone_is_freed_at_once(rig: Rig) -> None:
    """Their memory does not wait for the garbage collector, whose full run stops the event loop."""
    ada = await rig.enter("ada-1111")
    ada.says(type="name", name="Ada")
    ada.says(type="join")
    rig.wait(0.5, ada)
    (viewer,) = rig.viewers
    left = [weakref.ref(one) for one in (viewer, viewer.streams)]
    gc.disable()
    try:
        ada.abandon()
        del ada, viewer
        FakePeer.made.clear()
        rig.wait(60.0)
        assert rig.names() == []
        assert [one() for one in left if one() is not None] == []
    finally:
        gc.enable()


async def test_a_full_house_says_so(rig: Rig) -> None:
    """One viewer too many is refused with a sentence, and the others are not affected."""
    await rig.enter("ada-1111")
    await rig.enter("bob-1111")
    with pytest.raises(FullError, match="2 places"):
        await rig.room.answer(visitor("eve-1111"), TAB, OFFER)
    assert len(rig.names()) == 2


async def test_a_full_upload_refuses_only_new_guests() -> None:
    """A newcomer who cannot get a picture is refused with a sentence; others may return."""
    rig = Rig({"network": {"upload_bps": 60_000}})
    await rig.enter("ada-1111")
    with pytest.raises(FullError, match="carries no more viewers"):
        await rig.room.answer(visitor("eve-1111"), TAB, OFFER)
    await rig.enter("ada-1111")
    await rig.enter("host-111", is_host=True)
    assert len(rig.names()) == 2


async def test_a_busy_machine_says_so_to_newcomers_beyond_a_dozen() -> None:
    """The operator must not wait for one more viewer; a late event loop alone refuses nobody."""
    rig = Rig({})
    rig.keep_busy(share=1.0)
    for number in range(10, 22):
        await rig.enter(f"ada-11{number}")
        for _ in range(20):
            rig.clock.time_s += 0.045
            rig.loop.step(rig.clock.time_s)
    with pytest.raises(NoPlaceError, match="computer can serve no more") as refused:
        await rig.enter("eve-1111")
    assert refused.value.retry_after_s == 3, "a rush is soon over"
    await rig.enter("ada-1110")
    await rig.enter("host-111", is_host=True)
    rig.keep_busy(share=0.1)
    await rig.enter("eve-1111")


@pytest.mark.parametrize("who", ["in a room", "lost", "silent"])
async def test_only_viewers_served_here_count_among_the_dozen(who: str) -> None:
    """Others, in a LiveKit room, gone or not connected yet, cost this machine next to nothing."""
    rig = Rig({})
    rig.keep_busy(share=1.0)
    for number in range(10, 22):
        await rig.enter(f"ada-11{number}")
        rig.clock.time_s += 0.9
    with pytest.raises(NoPlaceError):
        await rig.enter("eve-1111")
    one = next(iter(rig.room._viewers))
    assert one.peer is not None
    match who:
        case "in a room":
            one.in_room_until_s = math.inf
            rig.room.viewer_closed(one, one.peer)
        case "lost":
            rig.room.viewer_closed(one, one.peer)
        case _:
            one.is_ready = one.was_ready = False
    await rig.enter("eve-1111")


async def test_silence_stops_the_robot_and_keeps_the_turn(rig: Rig) -> None:
    """An operator silent for the announced time is lost: the robot stops, their turn is kept."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.2, ada, bob)
    rig.robot.told.clear()
    lost_after_s = ada.last("hello")["on_loss"]["lost_after_ms"] / 1000
    assert lost_after_s == 1.0
    rig.wait(lost_after_s - 0.1, bob)
    assert not any(line["lost"] for line in bob.last("room")["viewers"])
    rig.wait(0.3, bob)
    lines = {line["id"]: line for line in bob.last("room")["viewers"]}
    assert lines[1]["lost"]
    assert lines[1]["role"] == "operator"
    assert "stop" in rig.robot.told
    rig.wait(0.2, ada, bob)
    assert not bob.last("room")["viewers"][0]["lost"]


async def test_an_observer_may_be_silent_for_longer(rig: Rig) -> None:
    """An observer sends a heartbeat once a second, so they are lost after 3.5 s and not before."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    rig.wait(3.4, ada)
    assert not any(line["lost"] for line in ada.last("room")["viewers"])
    rig.wait(0.3, ada)
    lost = {line["id"]: line["lost"] for line in ada.last("room")["viewers"]}
    assert lost == {1: False, 2: True}
    assert bob.is_alive


async def test_a_closed_page_is_forgotten_after_the_grace_time() -> None:
    """A closed page keeps its place for the grace time, then it is free."""
    rig = Rig({})
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    bob.says(type="join")
    rig.wait(0.2, ada, bob)
    ada.abandon()
    rig.wait(7.5, bob)
    assert bob.last("room")["turn"]["operator"] == 1
    rig.wait(1.0, bob)
    assert bob.last("room")["turn"]["operator"] == 2
    assert len(bob.last("room")["viewers"]) == 1


async def test_half_open_and_dead_peers_are_closed(rig: Rig) -> None:
    """A page that never opens its channels, and one that falls silent, are closed in 10 s."""
    await rig.room.answer(visitor("ada-1111"), TAB, OFFER)
    half = FakePeer.made[-1]
    bob = await rig.enter("bob-1111")
    rig.wait(10.3)
    assert not half.is_alive
    assert not bob.is_alive
    rig.wait(9.0)
    assert not list(rig.viewers)


async def test_a_page_that_cannot_offer_is_offered_one_and_answers(rig: Rig) -> None:
    """Only the tab that was offered it can answer, by a description that an offer could be."""
    ada, bob = visitor("ada-1111"), visitor("bob-1111")
    assert await rig.room.answer(ada, TAB, "") == "our offer"
    for who, tab, answer in [(bob, TAB, OFFER), (ada, "tab-2222", OFFER), (ada, TAB, "v=1")]:
        with pytest.raises(SignallingError):
            await rig.room.accept(who, tab, answer)
    peer = FakePeer.made[-1]
    assert peer.accepted == ""
    await rig.room.accept(ada, TAB, OFFER)
    assert peer.accepted.startswith("v=0")
    await rig.room.answer(ada, TAB, "")
    assert not peer.is_alive


async def test_a_turn_changes_hands_with_a_stop_between(rig: Rig) -> None:
    """At the end of a turn the robot stops before the next operator is told of their turn."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    bob.says(type="join")
    rig.wait(0.2, ada, bob)
    rig.robot.told.clear()
    rig.wait(5.0, ada, bob)
    assert "stop" in rig.robot.told
    told = bob.last("room")
    assert (told["turn"]["operator"], told["turn"]["number"]) == (2, 2)
    assert {line["id"]: line["place"] for line in told["viewers"]} == {1: 1, 2: 0}


async def test_only_the_operator_drives(rig: Rig) -> None:
    """Another viewer's command moves nothing."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.2, ada, bob)
    rig.drive(bob, 1, linear=1.0)
    rig.wait(0.2, ada, bob)
    twists = [told for told in rig.robot.told if isinstance(told, Twist)]
    assert all(twist.is_zero for twist in twists)
    assert rig.counters.snapshot()["messages not allowed"] == 1


async def test_everybody_may_stop_and_all_read_who(rig: Rig) -> None:
    """An observer's Stop reaches the robot at once, latches, and everybody sees their name."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    bob.says(type="name", name="Bob")
    rig.wait(0.2, ada, bob)
    rig.robot.told.clear()
    bob.says(type="stop")
    assert rig.robot.told == ["stop"]
    rig.wait(0.1, ada, bob)
    assert ada.last("room")["stop"] == _stop("Bob", number=1, viewer=2)
    assert bob.last("room")["stop"] == _stop("Bob", number=1, viewer=2)


async def test_only_operator_and_host_may_release(rig: Rig) -> None:
    """An observer's release is answered with a sentence; the operator's and the host's count."""
    ada = await rig.enter("ada-1111")
    bob = await rig.enter("bob-1111", is_host=False)
    ada.says(type="join")
    rig.wait(0.2, ada, bob)

    def release(peer: FakePeer, stop: int) -> None:
        peer.says(type="release", stop=stop, sent_server_ms=rig.clock.time_s * 1000, beat=peer.beat)
        rig.wait(0.1, ada, bob)

    bob.says(type="stop")
    for early in (bob, ada):
        release(early, 1)
        assert early.last("notice")["text"]
        assert ada.last("room")["stop"] is not None
    rig.wait(3.0, ada, bob)
    release(ada, 1)
    assert ada.last("room")["stop"] is None
    bob.says(type="stop")
    host = list(rig.viewers)[1]
    host.visitor = replace(host.visitor, sign_in=rig.sign_in())
    release(bob, 2)
    assert ada.last("room")["stop"] is None
    bob.says(type="stop")
    release(ada, 3)
    assert ada.last("room")["stop"]["by_host"]
    release(bob, 3)
    assert ada.last("room")["stop"] is None


async def test_a_stop_and_the_paused_clock_are_sent_together(rig: Rig) -> None:
    """Both change the page at once, so that no button moves from under a finger a second time."""
    ada = await rig.enter("ada-1111")
    bob = await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.3, ada, bob)
    for peer, kind in (bob, "stop"), (ada, "release"):
        rig.wait(3.0, ada, bob)
        stamp = {"stop": 1, "sent_server_ms": rig.clock.time_s * 1000, "beat": ada.beat}
        peer.says(type=kind, **(stamp if kind == "release" else {}))
        rig.round()  # before the robot has its next set-point
        room = ada.last("room")
        stands = room["turn"]["stands_left_ms"] is not None
        assert (room["stop"] is not None) is stands is (peer is bob)


async def test_stop_and_release_by_http(rig: Rig) -> None:
    """By HTTP everybody in the room may stop, and the operator or the host release."""
    ada = await rig.enter("ada-1111")
    bob = await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.2, ada, bob)
    rig.robot.told.clear()
    for client in ("", "eve-1111"):
        with pytest.raises(ForbiddenError):
            rig.room.stop_by(visitor(client), TAB)
    assert rig.robot.told == []
    number = rig.room.stop_by(visitor("bob-1111"), TAB)
    assert rig.robot.told == ["stop"]
    for client in ("", "eve-1111", "bob-1111"):
        with pytest.raises(ForbiddenError):
            rig.room.release_by(visitor(client), TAB, number)
    with pytest.raises(ForbiddenError):
        rig.room.release_by(visitor("ada-1111"), TAB, number + 1)
    rig.wait(0.1, ada)
    assert ada.last("room")["stop"] == _stop("Guest 2", number=number, viewer=2)
    rig.wait(3.0, ada)
    rig.room.release_by(visitor("ada-1111"), TAB, number)
    rig.wait(0.1, ada)
    assert ada.last("room")["stop"] is None
    number = rig.room.stop_by(visitor("ada-1111"), TAB)
    rig.room.release_by(visitor("", is_host=True), None, number)
    rig.wait(0.1, ada)
    assert ada.last("room")["stop"] is None


async def test_a_page_without_a_cookie_is_known_by_its_tab(rig: Rig) -> None:
    """A guest's page is known by its tab's secret; the secret makes nobody the host."""
    await rig.room.answer(visitor("ada-1111"), "ada's secret", OFFER)
    signed_in = replace(visitor("host-111"), sign_in=rig.sign_in())
    await rig.room.answer(signed_in, "the host's", OFFER)
    nobody = visitor("", address="192.0.2.9")
    assert rig.room.by_tab(nobody, "ada's secret") == visitor("ada-1111")
    for tab in ("", "ada's", "the host's", "\udcff"):
        assert rig.room.by_tab(nobody, tab) is nobody
    await rig.room.answer(visitor("ada-2222"), "ada's secret", OFFER)  # connected again
    assert rig.room.by_tab(nobody, "ada's secret") == visitor("ada-2222")


async def test_an_embed_has_no_role_by_its_tab(rig: Rig) -> None:
    """It has no tab secret, and so no Stop by HTTP."""
    await rig.room.answer(replace(visitor("embed 1"), is_embed=True), "", OFFER)
    nobody = visitor("")
    assert rig.room.by_tab(nobody, "") is nobody


async def test_only_the_operator_stops_where_so_configured() -> None:
    """By either way, an observer's Stop is refused and the host's is not."""
    closed = Rig({"stop": {"by": "operator"}})
    ada, bob = await closed.enter("ada-1111"), await closed.enter("bob-1111")
    ada.says(type="join")
    closed.wait(0.2, ada, bob)
    bob.says(type="stop")
    assert bob.last("notice")["text"] == {"code": "stop.only_operator"}
    for client in ("", "bob-1111"):
        with pytest.raises(ForbiddenError, match="operator or the host"):
            closed.room.stop_by(visitor(client), TAB)
    assert closed.room.stop_by(visitor("ada-1111"), TAB) == 1
    closed.room.release_by(visitor("ada-1111"), TAB, 1)
    assert closed.room.stop_by(visitor("", is_host=True), None) == 2


async def test_who_sees_the_picture(rig: Rig) -> None:
    """A viewer with the picture off does not see, and nobody does without a camera."""
    ada = await rig.enter("ada-1111")
    assert rig.viewers.sees(1)
    assert not rig.viewers.sees(9)
    ada.says(type="want", sound=True, picture=False, size="640x480", policy=None)
    assert not rig.viewers.sees(1)


async def test_a_driver_that_raises_is_a_problem_of_the_robot(rig: Rig) -> None:
    """When somebody's driver raises at every call, the room says so and goes on."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.2, ada)
    rig.robot.is_broken = True
    rig.wait(0.2, ada)
    assert ada.last("room")["robot"]["problem"] == NO_ANSWER.wire()
    rig.robot.is_broken = False
    rig.wait(0.2, ada)
    assert ada.last("room")["robot"]["problem"] is None


async def test_a_problem_of_the_robot_is_sent_at_once(rig: Rig) -> None:
    """Everybody reads within one round that the robot cannot be driven, also newcomers and the
    operator; only the host reads why.
    """
    ada, host = await rig.enter("ada-1111"), await rig.enter("host-111", is_host=True)
    ada.says(type="join")
    for after_s in (0.2, 0.3):  # whenever the room was last polled
        rig.robot.problem = None
        rig.wait(1.0 + after_s, ada, host)
        rig.robot.problem = "/dev/ttyACM0 is unplugged"
        rig.wait(0.1, ada, host)
        assert host.last("room")["robot"]["problem"] == says("/dev/ttyACM0 is unplugged").wire()
        assert ada.last("room")["robot"]["problem"] == {"code": "robot.trouble"}
    rig.wait(0.5, ada, host)
    assert ada.last("drive_status")["reason"] == {"code": "robot.trouble"}
    again = await rig.enter("ada-1111")
    rig.wait(0.5, again, host)
    assert again.last("room")["robot"]["problem"] == {"code": "robot.trouble"}
    assert not [one for one in (*ada.sent, *again.sent) if "/dev/" in json.dumps(one)]


async def test_the_robots_watchdog_time_is_passed_on(rig: Rig) -> None:
    """It is sent in ms, 0 for a robot that never stops by itself, null for an unknown time."""
    ada = await rig.enter("ada-1111")
    told: list[tuple[float | None, float | None]] = [(None, None), (0.5, 500.0), (0.0, 0.0)]
    for rig.robot.ttl_s, ttl_ms in told:
        rig.wait(0.5, ada)
        assert ada.last("room")["robot"]["ttl_ms"] == ttl_ms


async def test_everybody_is_told_of_the_person_aboard() -> None:
    """Everybody reads whether they drive, and what they ask for."""
    rig = Rig({"local": {"source": "serial"}})
    ada = await rig.enter("ada-1111")
    rig.wait(0.2, ada)
    assert ada.last("room")["aboard"]["mode"] == "lost"
    rig.robot.aboard = Aboard("hand", 0.0, "wait", 3)
    rig.wait(0.3, ada)
    told = ada.last("room")["aboard"]
    assert told == {
        "mode": "hand",
        "reason": ABOARD["hand"].wire(),
        "asked": "wait",
        "asks": 3,
        "takes_part": False,
    }
    rig.robot.aboard = Aboard("free", 1.0, "wait", 3)
    rig.wait(0.5, ada)
    assert ada.last("room")["aboard"]["reason"] is None


async def test_without_a_person_aboard_none_is_shown(rig: Rig) -> None:
    """Whatever the driver says, nobody is shown unless the person aboard is configured."""
    ada = await rig.enter("ada-1111")
    rig.wait(0.2, ada)
    assert ada.last("room")["aboard"] is None


async def test_an_operator_is_an_adviser_while_the_person_aboard_drives(rig: Rig) -> None:
    """Their commands do not count, their turn's clock is paused, and they may still stop."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.1, ada)
    rig.drive(ada, 1, linear=0.0)
    rig.robot.aboard = Aboard("hand", 0.0)
    rig.wait(0.2, ada)
    rig.robot.told.clear()
    rig.drive(ada, 2, linear=0.0)
    rig.drive(ada, 3, linear=1.0)
    rig.wait(0.1, ada)
    assert all(one in (STANDSTILL, "stop") for one in rig.robot.told)
    assert rig.counters.snapshot()["messages not allowed"] == 2
    assert rig.room.snapshot(rig.clock.time_s).turn.stands_left_ms is not None
    ada.says(type="stop")
    rig.wait(0.1, ada)
    assert rig.loop.latched is not None


async def test_a_failing_camera_and_its_recovery_are_shown(rig: Rig) -> None:
    """The page says that the camera is gone, and that it is back."""
    ada = await rig.enter("ada-1111")
    rig.camera.problem = Sentence("camera.silent")
    rig.wait(0.3, ada)
    assert ada.last("room")["video"]["problem"] == {"code": "camera.trouble"}
    rig.camera.problem = None
    rig.wait(0.3, ada)
    assert ada.last("room")["video"]["problem"] is None


async def test_a_flood_of_messages_hides_nobodys_silence(rig: Rig) -> None:
    """While one viewer keeps changing their name, a silent operator is still lost in time."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.2, ada, bob)
    bob.sent.clear()
    for step in range(120):
        bob.says(type="name", name=f"Bob {step}")
        rig.wait(0.1, bob)
        if step == 11:
            assert rig.room.snapshot(rig.clock.time_s).viewers[0].lost
    assert len(bob.sent) <= 121


async def test_a_flood_is_not_read(rig: Rig) -> None:
    """Messages over the rate are counted and dropped before they cost anything."""
    ada = await rig.enter("ada-1111")
    for step in range(500):
        ada.says(type="name", name=f"Ada {step}")
    assert rig.counters.snapshot()["messages over the rate"] == 440
    rig.wait(1.0, ada)
    ada.says(type="name", name="Ada")
    rig.wait(1.1, ada)
    assert rig.names() == ["Ada"]


async def test_bad_offers_take_no_place(rig: Rig) -> None:
    """However many bad offers come, the room is not full and nobody's peer is closed."""
    ada = await rig.enter("ada-1111")
    for number in range(50):
        with pytest.raises(SignallingError):
            await rig.room.answer(visitor(f"eve-{number:04}"), TAB, "nonsense")
        with pytest.raises(SignallingError):
            await rig.room.answer(visitor("ada-1111"), TAB, "nonsense")
    assert ada.is_alive
    await rig.enter("bob-1111")
    assert len(rig.names()) == 2


async def test_a_browser_without_our_codec_is_told_so_each_time(rig: Rig) -> None:
    """However often it tries, it reads about the codec, and not that others are connecting."""
    for kind, codec in (("video", "VP8"), ("audio", "opus")):
        offer = OFFER.replace(codec, "other")
        for _ in range(20):
            with pytest.raises(SignallingError) as refused:
                await rig.room.answer(visitor("eve-1111"), TAB, offer)
            assert refused.value.sentence.code == f"request.no_{kind}_codec"
    assert rig.names() == []


async def test_a_peer_that_never_opened_frees_its_place_at_once(rig: Rig) -> None:
    """A viewer who failed to connect has no place to keep, and so no grace time."""
    await rig.enter("ada-1111")
    await rig.room.answer(visitor("eve-1111"), TAB, OFFER)
    FakePeer.made[-1].abandon()
    await rig.enter("bob-1111")
    assert len(rig.names()) == 2


async def test_of_two_offers_at_once_the_later_wins(rig: Rig) -> None:
    """A page that offers twice at once ends with one living peer, the one of its later offer."""
    ada = visitor("ada-1111", address="")
    await asyncio.gather(*(rig.room.answer(ada, TAB, OFFER) for _ in range(3)))
    assert [peer.is_alive for peer in FakePeer.made] == [False, False, True]
    assert len(rig.viewers) == 1


async def test_everybody_queues_where_it_is_so_configured() -> None:
    """With `join = "auto"` the first to enter drives and the next waits (thesis 4.3)."""
    everybody = Rig({"turns": {"join": "auto"}})
    ada, bob = await everybody.enter("ada-1111"), await everybody.enter("bob-1111")
    everybody.wait(0.3, ada, bob)
    roles = [line["role"] for line in bob.last("room")["viewers"]]
    assert roles == ["operator", "queued"]


async def test_nothing_unchanged_is_sent_again(rig: Rig) -> None:
    """While nothing changes, nothing is sent but the estimated wait, every 5 s."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    rig.wait(0.2, ada, bob)
    ada.sent.clear()
    rig.wait(12.0, ada, bob)
    assert ada.sent == []
    ada.says(type="join")
    bob.says(type="join")
    rig.wait(0.2, ada, bob)
    bob.sent.clear()
    rig.wait(4.5, ada, bob)
    assert sum(m["type"] == "room" for m in bob.sent) == 1


async def test_the_role_brings_its_policy(rig: Rig) -> None:
    """At hand-over the playout policy changes with the role, live."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.2, ada)
    assert ada.last("playout")["policy"] == "video-first"
    ada.says(type="leave")
    rig.wait(0.2, ada)
    assert ada.last("playout")["policy"] == "audio-master"


async def test_only_the_operator_gets_the_status_of_their_commands(rig: Rig) -> None:
    """Only the operator is told that the robot moves, or why it does not."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    rig.wait(0.3, ada, bob)
    for seq in range(1, 8):
        rig.drive(ada, seq, linear=0.0 if seq < 3 else 0.5)
        rig.wait(0.1, ada, bob)
    freely = {"type": "drive_status", "moving": True, "reason": None, "share": 1.0}
    assert ada.last("drive_status") == freely
    rig.wait(1.5, ada, bob)
    told = [message for message in ada.sent if message["type"] == "drive_status"]
    assert not told[-1]["moving"]
    assert told[-1]["reason"]
    assert not [message for message in bob.sent if message["type"] == "drive_status"]
    rig.wait(2.0, ada, bob)
    assert [message for message in ada.sent if message["type"] == "drive_status"] == told


async def test_a_reloaded_page_gets_the_status_of_its_commands(rig: Rig) -> None:
    """An operator who reloads is told again why the robot is stopped, even if that is unchanged."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.robot.problem = "the line is unplugged"
    rig.wait(0.5, ada)
    assert ada.last("drive_status")["reason"]
    again = await rig.enter("ada-1111")
    rig.wait(0.5, again)
    assert again.last("drive_status")["reason"]


@pytest.mark.parametrize("is_host", [False, True])
async def test_nobody_keeps_a_missing_tape(rig: Rig, is_host: bool) -> None:
    """The host reads that nothing is recorded, and the others that they may not keep it."""
    ada = await rig.enter("ada-1111", is_host=is_host)
    ada.says(type="keep_tape")
    code = "tape.none" if is_host else "may.operator"
    assert ada.last("notice")["text"] == {"code": code}
    rig.wait(0.3, ada)
    assert ada.last("room")["tape"] is None


async def test_the_tape_is_asked_by_page(rig: Rig) -> None:
    """What operators say of their turns reaches the tape, and the page gets the answer."""
    asked: list[tuple[int, int, str]] = []

    class Keeper:
        def set_task(self, viewer: int, task: messages.SetTask) -> None:
            asked.append((viewer, task.turn, task.text))

        def disown(self, viewer: int, turn: int) -> Sentence:
            asked.append((viewer, turn, "disowned"))
            return Sentence("tape.disowned")

    rig.room._tape = cast("TapeKeeper", Keeper())
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    ada.says(type="join")
    for one in (ada, bob):
        one.says(type="task", turn=1, text="to the red post")
    assert bob.last("notice")["text"] == {"code": "may.operator"}
    ada.says(type="leave")
    ada.says(type="disown", turn=1)
    assert ada.last("notice")["text"] == {"code": "tape.disowned"}
    assert asked == [(1, 1, "to the red post"), (1, 1, "disowned")]


def _stop(name: str, **known: Any) -> dict[str, Any]:
    by = Sentence("by.named", {"name": name})
    return messages.StopInfo(by=by, **known).model_dump(mode="json")


async def test_deferred_names_are_compared_one_per_step() -> None:
    """Many names changed at the same time are compared one per step of the event loop."""
    rig = Rig({})
    peers = [await rig.enter(f"guest-{number}") for number in range(6)]
    for number, peer in enumerate(peers):
        for name in ("Early", "Late"):
            peer.says(type="name", name=f"{name} {number}")
    rig.clock.time_s += 3.0
    rig.round()

    def renamed() -> int:
        return sum(viewer.name.startswith("Late") for viewer in rig.viewers)

    for number in range(1, len(peers) + 1):
        assert renamed() == number
        await asyncio.sleep(0)


async def test_a_change_is_sent_to_a_few_per_step() -> None:
    """The host's console is made in parts, too; all get the same change, and it is complete."""
    rig = Rig({})
    hedy = await rig.enter("host-111", is_host=True)
    peers = [hedy, *[await rig.enter(f"guest-{number}") for number in range(2 * PORTION)]]
    rig.clock.time_s += 1.1
    for peer in peers:
        peer.pings()
    rig.round()
    for _ in peers:
        await asyncio.sleep(0)
    consoles = [message for message in hedy.sent if message["type"] == "console"]
    assert len(consoles[-1]["viewers"]) == len(peers)
    peers[1].says(type="name", name="Ada")
    rig.clock.time_s += 1.1
    for peer in peers:
        peer.pings()
    before = [len(peer.sent) for peer in peers]
    rig.round()
    told = [len(peer.sent) - sent for peer, sent in zip(peers, before, strict=True)]
    assert sum(map(bool, told)) <= PORTION
    for _ in peers:
        await asyncio.sleep(0)
    for peer in peers:
        assert "Ada" in [line["name"] for line in peer.last("room")["viewers"]]


async def test_closing_sends_a_few_away_per_step() -> None:
    """In the end everybody is sent away, except viewers who have left meanwhile."""
    rig = Rig({})
    peers = [await rig.enter(f"guest-{number}") for number in range(2 * PORTION)]
    rig.access.close(True)
    rig.room._presence.check_all()
    assert len(rig.viewers) == PORTION
    gone = peers[-1]
    rig.room._presence.send_away(next(reversed(list(rig.viewers))), CLOSED)
    for _ in peers:
        await asyncio.sleep(0)
    assert len(rig.viewers) == 0
    assert sum(message["type"] == "ended" for message in gone.sent) == 1


async def test_only_changed_lines_of_the_room_are_made_anew(rig: Rig) -> None:
    """Unchanged lines are the same objects, so that a crowd's lines compare fast."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    before = rig.room.snapshot(rig.clock.time_s).viewers
    ada.says(type="name", name="Ada")
    rig.wait(0.2, ada, bob)
    after = rig.room.snapshot(rig.clock.time_s).viewers
    assert [one is other for one, other in zip(before, after, strict=True)] == [False, True]


async def test_a_turn_changes_the_policy_of_its_operator_alone(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many watch, nothing is done for them when a turn begins or ends."""
    ada, _ = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    followed: list[tuple[int, bool]] = []
    for viewer in rig.viewers:
        monkeypatch.setattr(
            viewer,
            "set_role",
            lambda _, *, drives, number=viewer.number: followed.append((number, drives)),
        )
    ada.says(type="join")
    ada.says(type="leave")
    assert followed == [(1, True), (1, False)]


async def test_a_viewer_who_joins_and_leaves_without_end_is_slowed_down(rig: Rig) -> None:
    """After ten times, each time costs them two seconds; the next person joins meanwhile."""
    ada, bob = await rig.enter("ada-1111"), await rig.enter("bob-1111")
    for _ in range(10):
        ada.says(type="join")
        ada.says(type="join")  # asking for a place again loses none
        assert rig.turns.operator == 1
        ada.says(type="leave")
    ada.says(type="join")
    assert rig.turns.operator is None
    assert ada.last("notice")["text"] == {"code": "queue.too_often"}
    bob.says(type="join")
    assert rig.turns.operator == 2
    bob.says(type="leave")
    rig.wait(2.1, ada, bob)
    ada.says(type="join")
    assert rig.turns.operator == 1


async def test_rounds_are_rare_while_nobody_is_there(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One round a second runs for nobody, and all of them for a viewer."""
    monkeypatch.setattr(room_module, "_ROUND_S", 0.0)
    rounds: list[float] = []
    whole = rig.room.round

    def noted(now_s: float) -> Iterator[None]:
        rounds.append(now_s)
        return whole(now_s)

    monkeypatch.setattr(rig.room, "round", noted)

    async def pass_s(tenths: int) -> list[float]:
        rounds.clear()
        for _ in range(tenths):
            rig.clock.time_s += 0.1
            before = len(rounds)
            for _ in range(10):
                await asyncio.sleep(0)
                if len(rounds) > before:
                    break
        return rounds

    running = asyncio.create_task(rig.room.run())
    await pass_s(1)
    assert len(await pass_s(30)) in (2, 3)
    await rig.enter("anna")
    assert len(set(await pass_s(30))) >= 30
    running.cancel()
