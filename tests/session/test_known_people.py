"""People whom a proxy knows, in a real room: one person on all devices, until they sign out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from tests.session.rig import OFFER, FakeCluster, FakePeer, Rig
from tests.visitors import TAB

from wax.access.access import Shown
from wax.access.admission import BANNED
from wax.access.vouching import NOT_SIGNED_IN
from wax.cluster.room_directory import person
from wax.errors import ForbiddenError, NotAdmittedError
from wax.session.presence import LOST_S

if TYPE_CHECKING:
    from wax.access.admission import Visitor

PROXY: dict[str, Any] = {
    "person": "Remote-User",
    "name": "Remote-Name",
    "groups": "Remote-Groups",
    "host": ["staff"],
    "drive": ["pupils"],
    "watch": ["guests"],
}
WITHIN_S = 60.0


def make(cluster: FakeCluster | None = None, **proxy: Any) -> Rig:
    tree = {
        "access": {"proxy": PROXY | proxy},
        "turns": {"turn_s": 300.0},
        "stop": {"max_per_minute": 3, "max_per_minute_per_address": 2},
        "server": {"trusted_proxies": ["127.0.0.1"], "max_viewers": 8},
    }
    return Rig(tree, cluster)


@pytest.fixture
def rig() -> Rig:
    return make()


class Known:
    """A person in one browser; each `asks` is a request through the proxy."""

    def __init__(self, rig: Rig, name: str, groups: str = "pupils", device: str = "a") -> None:
        self.rig, self.name, self.groups, self.device = rig, name, groups, device
        self.shown = name.title()

    def visitor(self, address: str = "192.0.2.1") -> Visitor:
        said = {
            "remote-user": [self.name],
            "remote-name": [self.shown],
            "remote-groups": [self.groups],
        }
        cookie = self.rig.access._keyring._identities.sign(self.device).decode()
        return self.rig.access.visitor(Shown(cookie, said=said), address)

    def asks(self) -> None:
        self.rig.room.renew(self.visitor())

    async def enters(self, tab: str = TAB) -> FakePeer:
        on_device = self.rig.access.on_device(self.visitor(), self.device)
        await self.rig.room.answer(on_device, tab, OFFER)
        FakePeer.made[-1].open()
        FakePeer.made[-1].pings()
        return FakePeer.made[-1]


def kinds(peer: FakePeer) -> set[str]:
    return {one["type"] for one in peer.sent}


async def test_who_signs_out_is_sent_away_within_a_minute(rig: Rig) -> None:
    """Whoever shows no more that the proxy lets them in stops driving, and is told to sign in."""
    alice = Known(rig, "alice")
    page = await alice.enters()
    page.says(type="join")
    for _ in range(8):
        rig.wait(15.0, page)
        alice.asks()
    assert rig.turns.operator is not None
    rig.wait(WITHIN_S - LOST_S, page)
    assert page.last("ended")["text"]["code"] == NOT_SIGNED_IN.code
    assert rig.turns.operator is None
    rig.wait(0.5)
    assert len(rig.viewers) == 0


async def test_another_device_does_not_prove_it(rig: Rig) -> None:
    """Each browser is signed in by itself: one that signs out is sent away, the other stays."""
    here, there = Known(rig, "alice"), Known(rig, "alice", device="b")
    page, other = await here.enters(), await there.enters("tab-2222")
    for _ in range(4):
        rig.wait(15.0, page, other)
        there.asks()
    assert "ended" in kinds(page)
    assert "ended" not in kinds(other)


@pytest.mark.parametrize("groups", ["", "guests,strangers", "expelled"])
async def test_a_group_that_is_taken_away_counts_no_more(groups: str) -> None:
    """Who may only watch now loses the turn within a second; who may not is sent away."""
    rig = make(refuse=["expelled"])
    alice = Known(rig, "alice")
    page = await alice.enters()
    page.says(type="join")
    assert rig.turns.operator is not None
    alice.groups = groups
    alice.asks()
    rig.wait(1.2, page)
    assert rig.turns.operator is None
    assert ("ended" in kinds(page)) == ("guests" not in groups)


async def test_a_host_by_group_is_one_only_while_in_it(rig: Rig) -> None:
    """Who is in the group acts as host; once out of it they do not, and their page starts anew."""
    alice, bob = Known(rig, "alice", "staff"), Known(rig, "bob")
    page, other = await alice.enters(), await bob.enters()
    page.says(type="lock", locked=True)
    assert rig.decisions.switches.is_locked
    other.says(type="lock", locked=False)
    assert rig.decisions.switches.is_locked
    alice.groups = "pupils"
    alice.asks()
    assert not page.is_alive
    page.says(type="lock", locked=False)
    assert rig.decisions.switches.is_locked
    rig.wait(1.2, other)
    assert "ended" not in kinds(other)


async def test_the_room_shows_the_name_that_the_proxy_tells(rig: Rig) -> None:
    """Nobody whom the proxy names calls themselves otherwise; a new name there is shown here."""
    alice = Known(rig, "alice")
    page = await alice.enters()
    page.says(type="name", name="Bob")
    assert rig.names() == ["Alice"]
    alice.shown = "Dr. Alice\u202e"
    alice.asks()
    rig.wait(1.2, page)
    assert rig.names() == ["Dr. Alice"]


@pytest.mark.parametrize("one_place", [True, False])
async def test_a_person_has_one_place_on_all_devices(*, one_place: bool) -> None:
    """Two devices of a person have one place in the queue, unless each is to have its own."""
    rig = make(one_place=one_place)
    page = await Known(rig, "alice").enters()
    other = await Known(rig, "alice", device="b").enters("tab-2222")
    page.says(type="join")
    other.says(type="join")
    rig.wait(0.3, page, other)
    assert len(rig.turns.queue) == (0 if one_place else 1)


async def test_a_ban_is_of_the_person(rig: Rig) -> None:
    """Who is banned stays out with another browser elsewhere; their neighbours come in."""
    host, alice = Known(rig, "hedy", "staff"), Known(rig, "alice")
    page, banned = await host.enters(), await alice.enters()
    number = banned.last("hello")["viewer"]
    page.says(type="remove", viewer=number, ban=True)
    assert banned.last("ended")["text"]["code"] == BANNED.code
    elsewhere = Known(rig, "alice", device="z").visitor("198.51.100.9")
    with pytest.raises(NotAdmittedError, match="leave"):
        rig.access.admit(elsewhere)
    assert rig.access.admit(Known(rig, "bob").visitor()).queue


async def test_stop_is_limited_by_person(rig: Rig) -> None:
    """Each person has their own presses of Stop, whoever else is at their address."""
    pages = [await Known(rig, name).enters() for name in ("alice", "bob", "carol", "dave")]
    for press, page in enumerate(pages):
        page.says(type="stop", press=press)
        rig.wait(0.2, *pages)
        stop = rig.loop.latched
        assert stop is not None
        assert stop.by.values["name"] in ("Alice", "Bob", "Carol", "Dave")
        rig.loop.release_stop("host", stop.number, rig.clock.time_s)
    assert all("notice" not in kinds(page) for page in pages)


async def test_a_seat_in_a_room_ends_with_the_sign_in() -> None:
    """Who watches in a LiveKit room loses the seat within a minute, too."""
    cluster = FakeCluster()
    rig = make(cluster)
    alice = Known(rig, "alice")
    on_device = rig.access.on_device(alice.visitor(), alice.device)
    name = person(on_device.identity, TAB)
    rig.room.rooms.seat(on_device, TAB)
    for _ in range(3):
        rig.wait(30.0)
        alice.asks()
    assert cluster.removed == []
    rig.wait(WITHIN_S)
    assert cluster.removed == [(name, True)]


@pytest.mark.parametrize("said", [{}, {"remote-user": [""]}, {"remote-user": ["alice", "bob"]}])
async def test_nobody_comes_in_unnamed(rig: Rig, said: dict[str, list[str]]) -> None:
    """No cookie lets in whom the proxy does not name, but for that of a host by a link."""
    cookie = rig.access.new_identity()
    stranger = rig.access.visitor(Shown(cookie, said=said), "192.0.2.1")
    assert stranger.identity == ""
    with pytest.raises(NotAdmittedError, match="sign"):
        rig.access.admit(stranger)
    with pytest.raises(NotAdmittedError, match="sign"):
        rig.access.on_device(stranger, "a")
    host = rig.access.become_host(rig.access.new_host_link())
    assert rig.access.admit(rig.access.visitor(Shown(cookie, host, said), "192.0.2.1")).queue


async def test_host_links_can_be_off() -> None:
    """Where groups say who is host, neither a new link nor an old cookie makes anybody host."""
    rig = make()
    cookie = rig.access.become_host(rig.access.new_host_link())
    rig.access._proxy = rig.access._proxy.model_copy(update={"host_link": False})
    assert not rig.access.visitor(Shown(host=cookie), "192.0.2.1").is_host
    with pytest.raises(ForbiddenError, match="groups"):
        rig.access.become_host(rig.access.new_host_link())
