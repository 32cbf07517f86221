"""People who watch in LiveKit rooms: who gets a seat, who loses it, who connects to drive."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from tests.session.rig import OFFER, FakeCluster, FakePeer, Rig
from tests.visitors import TAB, visitor

from wax.access.admission import BANNED, CLOSED
from wax.cluster.room_directory import person
from wax.errors import ForbiddenError, FullError, NoPlaceError, NotAdmittedError
from wax.session.host_acts import REMOVED
from wax.session.room_seats import SEAT_S, Seats
from wax.session.rooms import WATCHING_IS_FULL
from wax.session.stop_budget import FROM_ROOM, TOO_OFTEN

if TYPE_CHECKING:
    from wax.access.admission import Visitor
    from wax.sentence import Sentence


@pytest.fixture
def rooms() -> FakeCluster:
    return FakeCluster()


@pytest.fixture
def rig(rooms: FakeCluster) -> Rig:
    """Make a server with one place, and two LiveKit rooms with two seats each."""
    tree = {
        "access": {"hours": ["mon-sun 00:00-24:00"]},
        "turns": {"turn_s": 30.0, "grace_s": 2.0},
        "server": {"max_viewers": 1},
    }
    return Rig(tree, rooms)


EVE = visitor("eve-1111")
NAME = person("eve-1111", TAB)


def guest(number: int) -> Visitor:
    return visitor(f"guest-{number}", address=f"192.0.2.{number}")


def wait(rig: Rig, seconds: float, *alive: FakePeer) -> None:
    """Let time pass in steps of a second."""
    for _ in range(round(seconds)):
        rig.wait(1.0, *alive)


# --- seats -----------------------------------------------------------------------------------


async def test_a_visitor_without_a_place_gets_a_seat_in_a_room(
    rig: Rig, rooms: FakeCluster
) -> None:
    """The visitor gets two rooms to choose from, and the greeting that a viewer gets here."""
    await rig.enter("ada-1111")
    with pytest.raises(NoPlaceError) as here:
        await rig.room.answer(EVE, TAB, OFFER)
    told = rig.room.rooms.seat_instead(EVE, TAB, here.value)
    assert [one.url for one in told.rooms] == ["wss://a", "wss://b"]
    assert {one.token for one in told.rooms} == {NAME}
    assert (told.hello.viewer, told.hello.may_queue, told.hello.may_hear) == (0, True, True)
    rooms.has_sound = False
    assert rig.room.rooms.seat(EVE, TAB).hello.may_hear is False
    rooms.is_used = False
    with pytest.raises(NoPlaceError, match="The only place"):
        rig.room.rooms.seat_instead(guest(1), TAB, here.value)


async def test_without_a_free_seat_watching_is_full(rig: Rig, rooms: FakeCluster) -> None:
    """All rooms are full or gone; a viewer with a seat keeps it while its room is there."""
    for number in range(4):
        rig.room.rooms.seat(guest(number), TAB)
    with pytest.raises(FullError, match=str(WATCHING_IS_FULL)):
        rig.room.rooms.seat(EVE, TAB)
    assert rig.room.rooms.seat(guest(1), TAB).rooms[0].url == "wss://b"
    rooms.rooms.clear()
    with pytest.raises(FullError, match=str(WATCHING_IS_FULL)):
        rig.room.rooms.seat(guest(1), TAB)
    rooms.links.append("https://media.example.org")
    assert rig.room.rooms.seat(guest(1), TAB).links == ["https://media.example.org"]


async def test_the_rooms_get_no_details_of_a_fault(rig: Rig, rooms: FakeCluster) -> None:
    """Anybody may watch in LiveKit rooms, and nobody there is the host."""
    rig.room.rooms.seat(EVE, TAB)
    rig.robot.problem = "/dev/ttyACM0 is unplugged"
    rig.wait(0.1)
    news = rooms.news()
    assert news is not None
    assert "robot.trouble" in news
    assert "/dev/" not in news


async def test_a_seat_ends_unless_it_is_renewed(rig: Rig, rooms: FakeCluster) -> None:
    """A viewer who does not renew is removed from the rooms; LiveKit would let them stay."""
    rig.room.rooms.seat(EVE, TAB)
    rig.room.rooms.seat(guest(1), TAB)
    rig.clock.time_s += SEAT_S - 1
    rig.room.rooms.seat(EVE, TAB)
    rig.round()
    assert rooms.removed == []
    rig.clock.time_s += 1
    rig.round()
    assert rooms.removed == [(person("guest-1", TAB), False)]
    assert rig.room.role_of(EVE) == "observer"
    assert rig.room.role_of(guest(1)) == "stranger"
    assert [rig.room.has_people_at(f"192.0.2.{last}") for last in (1, 2)] == [True, False]


async def test_a_closed_page_gives_its_seat_back(rig: Rig, rooms: FakeCluster) -> None:
    """The seat is free for others at once; a page without one changes nothing."""
    rooms.rooms.pop()
    for number in range(2):
        rig.room.rooms.seat(guest(number), TAB)
    rig.room.rooms.leave(EVE, TAB)
    rooms.rooms[0].count(1)
    rooms.rooms[0].count(1)
    with pytest.raises(FullError):
        rig.room.rooms.seat(EVE, TAB)
    rig.room.rooms.leave(guest(1), TAB)
    assert rig.room.rooms.seat(EVE, TAB).wall_ms == rig.clock.wall_ms()
    assert rig.room.role_of(guest(1)) == "stranger"


async def test_closing_empties_the_rooms(rig: Rig, rooms: FakeCluster) -> None:
    """The host's own pages stay; the others are told why, and until when, if they ask."""
    host = await rig.enter("hedy-111", is_host=True)
    rig.room.rooms.seat(EVE, TAB)
    rig.room.rooms.seat(replace(visitor("hedy-111"), sign_in=rig.sign_in()), "tab-2222")
    host.says(type="close", closed=True)
    rig.wait(0.1, host)
    assert rooms.removed == [(NAME, True)]
    with pytest.raises(NotAdmittedError, match=str(CLOSED)) as told:
        rig.room.rooms.seat(EVE, TAB)
    assert len(told.value.openings) == 1
    with pytest.raises(NotAdmittedError, match=str(CLOSED)):
        rig.room.queue.request(EVE, TAB, "join")


@pytest.mark.parametrize(("ban", "sentence"), [(True, BANNED), (False, REMOVED)])
async def test_a_removed_viewer_loses_the_seat(
    rig: Rig, rooms: FakeCluster, ban: bool, sentence: Sentence
) -> None:
    """Every tab loses its seat and is told; without a ban the browser may return in a minute."""
    host = await rig.enter("hedy-111", is_host=True)
    rig.room.rooms.seat(EVE, TAB)
    rig.room.rooms.seat(EVE, "tab-2222")
    line = rig.room.queue.request(EVE, TAB, "join")
    host.says(type="remove", viewer=line.id, ban=ban)
    rig.wait(0.1, host)
    assert {who for who, for_good in rooms.removed if for_good} == {
        NAME,
        person("eve-1111", "tab-2222"),
    }
    with pytest.raises(NotAdmittedError, match=str(sentence)):
        rig.room.rooms.seat(EVE, TAB)
    rig.clock.time_s += 61
    if ban:
        with pytest.raises(NotAdmittedError, match=str(sentence)):
            rig.room.rooms.seat(EVE, TAB)
    else:
        assert rig.room.rooms.seat(EVE, TAB).rooms


async def test_a_ban_covers_the_address_too(rig: Rig, rooms: FakeCluster) -> None:
    """Others at that address lose their seats, too; they had no number to be banned by."""
    host = await rig.enter("hedy-111", is_host=True)
    rig.room.rooms.seat(EVE, TAB)
    rig.room.rooms.seat(visitor("eva-2222"), TAB)  # the same address
    rig.room.rooms.seat(guest(7), TAB)
    line = rig.room.queue.request(EVE, TAB, "join")
    host.says(type="remove", viewer=line.id, ban=True)
    rig.wait(0.1, host)
    assert {who for who, _ in rooms.removed} == {NAME, person("eva-2222", TAB)}


async def test_one_address_does_not_take_every_seat(rooms: FakeCluster) -> None:
    """An address has a share of the seats, as it has of the places here."""
    rooms.rooms[0].most = 100
    tree = {"server": {"max_share_per_address": 0.1}}
    rig = Rig(tree, rooms)
    for number in range(10):
        rig.room.rooms.seat(visitor(f"one-{number:04}"), TAB)
    with pytest.raises(FullError, match="your address"):
        rig.room.rooms.seat(EVE, TAB)
    assert rig.room.rooms.seat(guest(7), TAB).rooms


async def test_a_viewer_with_a_seat_stops_the_robot_within_a_budget(rig: Rig) -> None:
    """A seat gives the budget of a viewer; without one, nobody stops the robot."""
    with pytest.raises(ForbiddenError):
        rig.room.stop_by(EVE, TAB)
    rig.room.rooms.seat(EVE, TAB)
    number = rig.room.stop_by(EVE, TAB)
    latched = rig.room.snapshot(rig.clock.time_s).stop
    assert latched is not None
    assert (latched.number, latched.by) == (number, FROM_ROOM)
    with pytest.raises(ForbiddenError, match=str(TOO_OFTEN)):  # noqa: PT012 - the one too many
        for _ in range(10):
            rig.clock.time_s += 3.0
            rig.room.stop_by(EVE, TAB)


async def test_a_press_repeated_from_a_room_is_the_same_press(rig: Rig) -> None:
    """The page may repeat a press as often as it likes before it is answered."""
    rig.room.rooms.seat(EVE, TAB)
    numbers = set()
    for _ in range(10):
        numbers.add(rig.room.stop_by(EVE, TAB, 5))
        rig.clock.time_s += 4.0
    rig.room.release_by(visitor("", is_host=True), None, *numbers)
    assert {rig.room.stop_by(EVE, TAB, 5)} == numbers
    assert rig.room.snapshot(rig.clock.time_s).stop is None


async def test_without_a_cookie_a_page_in_a_room_is_known_by_its_tab(rig: Rig) -> None:
    """It is known by its newest seat, not by one that it left; the secret makes nobody the host."""
    seats, nobody = rig.room.rooms, visitor("")
    seats.seat(EVE, "eve's secret")
    assert rig.room.by_tab(nobody, "eve's secret") == EVE
    seats.seat(guest(7), "eve's secret")  # renewed as somebody new
    seats.leave(EVE, "eve's secret")
    assert rig.room.by_tab(nobody, "eve's secret") == guest(7)
    seats.leave(guest(7), "eve's secret")
    assert rig.room.by_tab(nobody, "eve's secret") is nobody
    seats.seat(replace(visitor("hedy-111"), sign_in=rig.sign_in()), "the host's")
    assert rig.room.by_tab(nobody, "the host's") is nobody


# --- the queue -------------------------------------------------------------------------------


async def test_joining_and_leaving_leaves_no_trace(rig: Rig) -> None:
    """Not even a refused request leaves anything."""
    for number in range(50):
        one = guest(number)
        assert rig.room.queue.request(one, TAB, "join").place is not None
        assert rig.room.queue.request(one, TAB, "leave").place is None
    with pytest.raises(ForbiddenError, match="join it first"):
        rig.room.queue.request(EVE, TAB, "stay")
    rig.room.queue.request(EVE, TAB, "join")
    with pytest.raises(ForbiddenError, match="another tab"):
        rig.room.queue.request(EVE, "tab-2222", "join")
    assert len(rig.viewers) == 1


async def test_a_place_that_is_not_renewed_is_lost(rig: Rig) -> None:
    """After twenty seconds the viewer is lost, and after the grace time forgotten."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    wait(rig, 1, ada)
    rig.room.queue.request(EVE, TAB, "join")
    for _ in range(3):
        wait(rig, 6, ada)
        assert rig.room.queue.request(EVE, TAB, "stay").place == 1
    wait(rig, 24, ada)
    assert [line["name"] for line in ada.last("room")["viewers"]] == ["Guest 1"]


async def test_a_viewer_who_does_not_connect_is_passed_over(rig: Rig) -> None:
    """Nobody drives from a LiveKit room: the turn passes to somebody who is connected here."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.5, ada)
    rig.room.queue.request(EVE, TAB, "join")
    for _ in range(7):
        wait(rig, 5, ada)
        if rig.viewers.of_tab("eve-1111", TAB) is not None:
            rig.room.queue.request(EVE, TAB, "stay")
    assert ada.last("room")["turn"]["operator"] == 1


async def test_a_viewer_who_connects_in_time_drives(rig: Rig) -> None:
    """A viewer in turn gets a place though all are taken; one who waits in a room takes none."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.5, ada)
    first = rig.room.queue.request(EVE, TAB, "join")
    second = rig.room.queue.request(guest(7), TAB, "join")
    assert (first.place, second.place) == (1, 2)
    with pytest.raises(NoPlaceError):
        await rig.room.answer(guest(7), TAB, OFFER)
    eve = await rig.enter("eve-1111")
    ada.says(type="leave")
    rig.wait(0.3, ada, eve)
    assert eve.last("room")["turn"]["operator"] == first.id


async def test_a_viewer_who_returns_to_a_room_keeps_the_place(rig: Rig) -> None:
    """A page that has driven and watches in a room again waits there for its next turn."""
    eve = await rig.enter("eve-1111")
    eve.says(type="join")
    rig.wait(0.3, eve)
    rig.room.queue.request(guest(7), TAB, "join")
    bob = await rig.enter("guest-7")
    wait(rig, 30, eve, bob)
    eve.abandon()
    line = rig.room.queue.request(EVE, TAB, "stay")
    assert (line.place, line.lost) == (1, False)


async def test_a_viewer_who_announces_the_return_keeps_the_place(rig: Rig) -> None:
    """Pages do so: they ask to keep the place, and only then close their connection."""
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    rig.wait(0.5, ada)
    rig.room.queue.request(EVE, TAB, "join")
    eve = await rig.enter("eve-1111")
    rig.room.queue.request(EVE, TAB, "stay")
    eve.abandon()
    for _ in range(4):
        line = rig.room.queue.request(EVE, TAB, "stay")
        assert (line.place, line.lost) == (1, False)
        wait(rig, 5, ada)


async def test_viewers_in_rooms_get_the_state_here(rig: Rig, rooms: FakeCluster) -> None:
    """While anybody is there, they read who drives, who waits first, and how many watch in all."""
    ada = await rig.enter("ada-1111")
    assert rooms.news() is None
    rig.room.rooms.seat(EVE, TAB)
    ada.says(type="join")
    rig.wait(0.3, ada)
    rooms.rooms[0].most = 1000
    for number in range(60):
        rig.room.queue.request(guest(number + 10), TAB, "join")
    text = rooms.news()
    assert text is not None
    assert len(text) < 15_000, "LiveKit passes on no more"
    told: dict[str, Any] = json.loads(text)
    assert told["watching"] == rooms.watching, "who drives does not watch"
    assert [line["place"] for line in told["room"]["viewers"]] == list(range(40))
    assert told["server_ms"] == rig.clock.time_s * 1000


async def test_each_viewer_is_counted_once(rig: Rig, rooms: FakeCluster) -> None:
    """The operator is left out, wherever they watched; a viewer who waits in a room counts."""

    def watching() -> int:
        text = rooms.news()
        assert text is not None
        count = json.loads(text)["watching"]
        assert isinstance(count, int)
        return count

    rig.room.rooms.seat(EVE, TAB)
    rig.room.rooms.seat(guest(7), TAB)
    rooms.watching = 2
    ada = await rig.enter("ada-1111")
    assert watching() == 3
    ada.says(type="join")
    rig.wait(0.3, ada)
    assert watching() == 2
    number = rig.room.queue.request(EVE, TAB, "join").id
    assert watching() == 2
    eve = await rig.enter("eve-1111")
    assert watching() == 2, "their page rests in the room meanwhile"
    ada.says(type="leave")
    rig.wait(0.3, ada, eve)
    assert ada.last("room")["turn"]["operator"] == number
    assert watching() == 2, "one in the room, and one here"


async def test_a_viewer_who_waits_in_a_room_has_a_name(rig: Rig) -> None:
    """Viewers here see the name; the name of somebody else is refused."""
    ada = await rig.enter("ada-1111")
    ada.says(type="name", name="Ada")
    ada.says(type="join")
    rig.wait(0.3, ada)
    assert rig.room.queue.request(EVE, TAB, "join", "Eve").name == "Eve"
    rig.wait(3, ada)
    assert rig.room.queue.request(EVE, TAB, "stay", "Ada").name == "Eve"
    rig.wait(3, ada)
    assert [line["name"] for line in ada.last("room")["viewers"]] == ["Ada", "Eve"]


def test_seats_are_counted_by_address_and_browser() -> None:
    """A renewed seat is the same one; the last one leaves no trace."""
    seats = Seats()
    for tab in ("tab-1111", "tab-2222", "tab-1111"):
        seats.give(EVE, tab, ["a"], 0.0)
    assert (len(seats), seats.at(EVE.address)) == (2, 2)
    assert {one.tab for one in seats.of_identity("eve-1111")} == {"tab-1111", "tab-2222"}
    assert seats.expire(SEAT_S - 1) == []
    assert len(seats.expire(SEAT_S)) == 2
    assert not seats.has("eve-1111")
    assert (seats.at(EVE.address), vars(seats)) == (
        0,
        {"_seats": {}, "_tabs": {}, "_newest": {}, "_addresses": {}},
    )
