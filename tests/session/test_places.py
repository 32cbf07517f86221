"""Who gets a place in the queue, whatever is sent, asked or lost, in a real room."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples
from tests.session.rig import OFFER, FakeCluster, FakePeer, Rig
from tests.turned_clock import TurnedClock
from tests.visitors import TAB, visitor

from wax.errors import ForbiddenError, WaxError

if TYPE_CHECKING:
    from wax.access.admission import Visitor

pytestmark = pytest.mark.usefixtures("_world")

GUESTS_ONLY = {"access": {"strangers_queue": False, "strangers_hear": False}}


@pytest.fixture(scope="module")
def _world() -> Any:
    with pytest.MonkeyPatch.context() as patched:
        # Invitations expire by the time of day.
        patched.setattr(TurnedClock, "wall_ms", lambda clock: round(clock.time_s * 1000))
        yield


def make(tree: dict[str, Any]) -> Rig:
    return Rig(tree, FakeCluster())


@pytest.mark.parametrize("join", ["ask", "auto"])
async def test_strangers_never_drive_where_an_invitation_is_needed(join: str) -> None:
    """Neither entering, nor asking, nor asking from a LiveKit room gives them a place."""
    rig = make(GUESTS_ONLY | {"turns": {"join": join}})
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    for wants in ("join", "stay"):
        with pytest.raises(ForbiddenError):
            rig.room.queue.request(visitor("eve-1111"), TAB, wants)
    rig.wait(0.3, ada)
    assert ada.last("room")["turn"]["operator"] is None
    assert [line["role"] for line in ada.last("room")["viewers"]] == ["observer"]


async def test_an_expired_invitation_ends_place_turn_and_sound() -> None:
    """The guest reads why at once, and watches on without sound if strangers have none."""
    rig = make(GUESTS_ONLY)
    token, _ = rig.access.invite("queue", uses=2, valid_s=20)
    friends = []
    for name in ("ada-1111", "bob-1111"):
        rig.access.enter(token, name)
        friends.append(await rig.enter(name))
    rig.wait(1.1, *friends)
    for friend in friends:
        friend.says(type="join")
        friend.says(type="want", sound=True, picture=True, size="640x480", policy=None)
    rig.wait(0.3, *friends)
    assert [line["place"] for line in friends[0].last("room")["viewers"]] == [0, 1]
    assert None not in [one.streams.status().entry["sound_mu_ms"] for one in rig.viewers]
    rig.wait(21.0, *friends)
    assert [line["place"] for line in friends[0].last("room")["viewers"]] == [None, None]
    for friend in friends:
        assert friend.last("notice")["text"] == {"code": "queue.not_invited"}
    assert [one.streams.status().entry["sound_mu_ms"] for one in rig.viewers] == [None, None]


async def test_nobody_waits_in_a_room_where_there_are_no_rooms() -> None:
    """Such a wait would be by HTTP alone, which the page of such a robot never does."""
    rooms = FakeCluster()
    rooms.is_used = False
    rig = Rig({}, rooms)
    with pytest.raises(ForbiddenError, match="join the queue there"):
        rig.room.queue.request(visitor("eve-1111"), TAB, "join")
    assert len(rig.viewers) == 0


async def test_a_connected_viewer_drives_however_many_wait_by_http() -> None:
    """Six who ask five times a second and never connect get no turn."""
    rig = make({"turns": {"turn_s": 10.0}})
    absent = [visitor(f"absent-{number:02}") for number in range(6)]
    for one in absent:
        rig.room.queue.request(one, TAB, "join")
    ada = await rig.enter("ada-1111")
    ada.says(type="join")
    number = ada.last("hello")["viewer"]
    for _ in range(200):
        rig.wait(0.2, ada)
        for one in absent:
            with suppress(ForbiddenError):
                rig.room.queue.request(one, TAB, "join")
        assert ada.last("room")["turn"]["operator"] in (None, number)
    assert ada.last("room")["turn"]["operator"] == number


class History:
    """Six pages of three people at two addresses, and a host; each method is one of their acts."""

    def __init__(self, rig: Rig, host: FakePeer) -> None:
        self.rig = rig
        self.host = host
        self.peers: dict[int, FakePeer] = {}
        self.drove: int | None = None

    def page(self, who: int) -> tuple[Visitor, str]:
        one = visitor(f"guest-{who // 2}", address=f"192.0.2.{who % 2}")
        return self.rig.access.refreshed(one), f"tab-{who:04}"

    async def enters(self, who: int) -> None:
        await self.rig.room.answer(*self.page(who), OFFER)
        self.peers[who] = FakePeer.made[-1]
        self.peers[who].open()

    async def is_cut_off(self, who: int) -> None:
        if who in self.peers:
            self.peers[who].abandon()

    async def says_join(self, who: int) -> None:
        if who in self.peers:
            self.peers[who].says(type="join")

    async def asks_to_join(self, who: int) -> None:
        self.rig.room.queue.request(*self.page(who), "join")

    async def asks_to_stay(self, who: int) -> None:
        self.rig.room.queue.request(*self.page(who), "stay")

    async def is_invited(self, who: int) -> None:
        token, _ = self.rig.access.invite("queue", uses=1, valid_s=4)
        self.rig.access.enter(token, self.page(who)[0].identity)

    async def is_removed(self, who: int) -> None:
        one, tab = self.page(who)
        if (viewer := self.rig.viewers.of_tab(one.identity, tab)) is not None:
            self.host.says(type="remove", viewer=viewer.number, ban=who == 0)

    async def host_holds(self, who: int) -> None:
        self.host.says(type="hold_queue", held=who == 0)

    async def host_ends_the_turn(self, _: int) -> None:
        self.host.says(type="end_turn", turn=self.rig.room.snapshot(0.0).turn.number)

    async def time_passes(self, who: int) -> None:
        alive = [peer for peer in self.peers.values() if peer.is_alive]
        self.rig.wait(1.1 + who, self.host, *alive)

    def check(self, most: int) -> None:
        self.rig.room._presence.check_all()
        room = self.rig.room.snapshot(self.rig.clock.time_s)
        lines = [one for one in room.viewers if one.place is not None]
        placed = [one for one in map(self.rig.viewers.numbered, (line.id for line in lines)) if one]
        assert all(self.rig.access.admit(one.visitor).queue for one in placed)
        people = [one.visitor.identity for one in placed]
        assert len(people) == len(set(people)), "one person has two places"
        at = [one.visitor.address for one in placed if one.number != room.turn.operator]
        assert all(at.count(one) <= most for one in at), "too many of one address wait"
        if room.turn.number != self.drove and room.turn.operator is not None:
            operator = self.rig.viewers.numbered(room.turn.operator)
            assert operator is not None
            assert operator.peer is not None, "a turn began for somebody who is not here"
        self.drove = room.turn.number


ACTS = [name for name in vars(History) if name[0] != "_" and name not in ("page", "check")]


@given(
    acts=st.lists(st.tuples(st.sampled_from(ACTS), st.integers(0, 5)), min_size=5, max_size=40),
    join=st.sampled_from(["ask", "auto"]),
    most=st.sampled_from([1, 2]),
    strangers=st.booleans(),
)
@examples(200)
async def test_no_history_gives_a_place_that_is_forbidden(
    acts: list[tuple[str, int]], join: str, most: int, strangers: bool
) -> None:
    """Whatever connects, is sent, asked, lost, comes back or is decided by the host: everybody
    with a place may queue, is one person, is within their address's limit, and drives from here.
    """
    turns = {"join": join, "max_waiting_per_address": most, "turn_s": 5.0, "grace_s": 2.0}
    rig = make({"turns": turns, "access": {"strangers_queue": strangers}})
    history = History(rig, await rig.enter("hedy-111", is_host=True))
    for act, who in acts:
        with suppress(WaxError):
            await getattr(history, act)(who)
        history.check(most)
