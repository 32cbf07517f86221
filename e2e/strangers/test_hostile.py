"""Strangers do their worst, in short: the robot drives on, Stop is heard, and nobody pays for them.

How fast is for ``make public``; here it counts what was asked, answered and given away, and the one
time that is a promise: Stop within 100 ms.
"""

from __future__ import annotations

import asyncio
import os
import random
import sys
import time
import uuid
from contextlib import AsyncExitStack
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

import pytest
import pytest_asyncio
from aiortc.rtcsctptransport import parse_packet
from aiortc.rtp import RtcpPacket, RtcpRtpfbPacket

from e2e.conftest import SERVERS
from e2e.harness import toml
from e2e.measure.table import to_table
from e2e.stop.operator import Browser, RawOperator
from e2e.stop.stage import LIGHT, STOPS_AT_EACH_TRIAL, staged
from e2e.strangers import wire
from e2e.strangers.attacks import ATTACKS, MIX, mixed
from e2e.strangers.by_http import silent_offer
from e2e.strangers.hostile import MORE_MIB, STOP_MS, Watch, begin, hostile, public_robot
from e2e.strangers.intruder import Answer, Intruder, ask
from e2e.strangers.late_liar import LateLiar
from e2e.strangers.strangers import Strangers, address, strangers

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from e2e.conftest import Serve
    from e2e.harness.server import Server
    from e2e.stop.stage import Load, Stage

pytestmark = [
    pytest.mark.timeout(60),
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux has all of 127.0.0.0/8"),
]

SECONDS: Final = 0.8
MIX_S: Final = 5.0
SHORT: Final = (
    *("feedback-4", "nacks", "chunks", "authenticated", "junk"),
    *("pipelined", "cookies-4", "never-read", "empty-offers"),
)
STOPS_S: Final = 0.8
CROWD: Final = "feedback-40"
MOST_BACK: Final = 1.2
"""Datagrams beside media for one that was sent; a room says something on its own, too."""
BACK_IN_TIME: Final = {"turns": {"grace_s": 8.0}}
"""As shipped, for whoever loses their connection."""
MANY: Final = 40
GUEST_S: Final = 3.0
LATE_S: Final = 0.6
"""More than the half second over which an honest page may drive."""
BOTH_WAYS: Final = 2
PRESS_S: Final = 0.2
MOST_PRESSES: Final = 3
"""The first is not believed before its page has been heard for a while."""
MOVES_S: Final = 0.5


@pytest.fixture(
    scope="module", params=["default", pytest.param("public-robot", marks=pytest.mark.full)]
)
def configuration(request: pytest.FixtureRequest) -> tuple[Mapping[str, Any], Load]:
    """Have a configuration, and what it serves."""
    return ({}, LIGHT) if request.param == "default" else public_robot()


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def stage(
    configuration: tuple[Mapping[str, Any], Load], pytestconfig: pytest.Config
) -> AsyncIterator[Stage]:
    """Have a robot that is driven, with the limits of one address as shipped."""
    tree, load = configuration
    settings = toml.as_shipped(), STOPS_AT_EACH_TRIAL, tree, BACK_IN_TIME
    async with staged(*settings, load=load) as made:
        pytestconfig.stash[SERVERS].append(made.server)
        yield made
        pytestconfig.stash[SERVERS].remove(made.server)
        await made.server.stop()


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def gang(stage: Stage) -> AsyncIterator[Strangers]:
    """Have the attackers' process."""
    async with strangers("attacks", stage.server.port) as made:
        yield made


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def watch(stage: Stage) -> AsyncIterator[Watch]:
    """Have somebody who drives, and somebody who watches."""
    async with (
        RawOperator(stage.server, sees=True) as operator,
        RawOperator(stage.server) as observer,
        Watch(stage, operator, observer) as made,
    ):
        await operator.join()
        yield made


@pytest.mark.parametrize(
    "name",
    [
        name if name in SHORT else pytest.param(name, marks=pytest.mark.full)
        for name in ATTACKS
        if name not in (MIX, CROWD)
    ],
)
async def test_an_attack_stops_no_robot_and_no_stop(
    name: str, watch: Watch, gang: Strangers
) -> None:
    """The robot drives on, Stop is heard, newcomers are served, and memory stays."""
    await _attacked(name, SECONDS, 0, watch, gang)


async def test_all_attacks_by_chance_are_no_worse(watch: Watch, gang: Strangers) -> None:
    """Whatever is drawn: WAX_SEED repeats one that failed."""
    seed = int(os.environ.get("WAX_SEED") or random.randrange(2**32))
    print(f"WAX_SEED={seed}")
    account = await _attacked(MIX, MIX_S, seed, watch, gang)
    for row, drawn in zip(mixed(random.Random(seed)), account["drawn"], strict=True):
        assert [str(one) for one in islice(row, len(drawn))] == drawn
        assert drawn


@pytest.mark.full
async def test_forty_hostile_viewers_delay_no_stop(
    configuration: tuple[Mapping[str, Any], Load],
) -> None:
    """Whoever watches beside them stops the robot in time, by HTTP and by the data channel."""
    tree, load = configuration
    rows = await hostile(CROWD, 5, tables=[tree], load=load)
    stops = [row for row in rows if ": Stop by " in row.key]
    assert len(stops) == 2
    assert all(row.met for row in stops), to_table(rows)


async def _attacked(
    name: str, seconds: float, seed: int, watch: Watch, gang: Strangers
) -> dict[str, Any]:
    await watch.steer()
    await begin(gang, name, seconds + STOPS_S, seed)
    before_mib = watch.mib()
    window = await watch.window(seconds)
    stops_ms = await watch.stops(2, window.until_s + STOPS_S)
    account = await gang.account()
    watch.fill(window)
    assert window.stands == 0, (window, account)
    assert window.unserved == 0, account
    took_ms = [ms for values in stops_ms.values() for ms in values]
    assert all(ms is not None and ms <= STOP_MS for ms in took_ms), (stops_ms, account)
    assert watch.peak_mib - before_mib <= MORE_MIB
    datagrams = account["datagrams"]
    if datagrams:
        assert datagrams.get("other", 0) <= MOST_BACK * datagrams["sent"], account
        first, again = (datagrams.get(f"{what} bytes", 0) for what in ("media", "again"))
        assert again <= first, account
    return account


def test_the_attacks_are_none_that_a_parser_would_refuse() -> None:
    """What is sent is whole and valid, so that it is the server's mercy that is tested."""
    for one in wire.DEMANDING:
        *_, chunks = parse_packet(wire.sctp(7, wire.full_of(one)))
        assert len(chunks) >= 50
    assert len(RtcpPacket.parse(wire.announces_lost(0, 65_535) * 28)) == 28
    (asks,) = RtcpPacket.parse(wire.nack(9, 1000, 128))
    assert isinstance(asks, RtcpRtpfbPacket)
    assert {873, 1000} <= set(asks.lost)


# --- what is decided in the wrong place ------------------------------------------------------


async def test_a_forged_datagram_ends_nobody(watch: Watch) -> None:
    """What comes from the operator's address, from whoever has no key, changes nothing."""
    since_s = time.monotonic()
    socket, where = watch.socket_of(watch.operator)
    for first in (b"\x80\x60", b"\x80\xc8", b"\x16\xfe\xfd", b"\x00\x01", b"\xff"):
        for size in (1, 12, 1499, 1500, 1501, 9000):
            socket.sendto((first + bytes(size))[:size], where)
    assert await watch.operator.pongs()
    assert await watch.observer.pongs()
    assert watch.stands(since_s, time.monotonic()) == 0


async def test_a_guest_behind_silent_offers_is_told_when_to_come(stage: Stage) -> None:
    """After forty that nobody followed up, whoever comes when told is in within three seconds."""
    source, sdp = address(201), await silent_offer()
    for _ in range(MANY):
        sent = {"sdp": sdp, "client": str(uuid.uuid4())}
        await ask(stage.server.port, "POST", "/api/offer", source=source, body=sent)
    guest, waited_s = Intruder(stage.server.port, source=source), 0.0
    try:
        while (answer := await guest.knock()).status == 429:
            waited_s += float(answer.headers["retry-after"])
            assert waited_s <= GUEST_S, answer.body
            await asyncio.sleep(float(answer.headers["retry-after"]))
        assert answer.status == 200, answer.body
    finally:
        await guest.close()


@pytest.mark.parametrize(("late_s", "may_drive"), [(0.0, True), (LATE_S, False)])
async def test_a_clock_that_lies_moves_nothing_on(
    late_s: float, may_drive: bool, stage: Stage, watch: Watch
) -> None:
    """A page that dates commands by their arrival is refused as an honest slow one is."""
    async with LateLiar(stage.server, late_s=late_s) as liar:
        await watch.operator.leave()
        await liar.join()
        await liar.media.arrived["video"].wait()  # nobody drives without a picture
        moved = False
        for _ in range(MOST_PRESSES if may_drive else 1):
            liar.let_go()
            await asyncio.sleep(BOTH_WAYS * late_s + PRESS_S)
            liar.steer(0.5)
            if moved := await stage.moves(late_s + MOVES_S):
                break
        await liar.leave()
    await watch.operator.join()
    assert moved is may_drive


async def test_empty_offers_of_a_neighbour_cost_no_turn(stage: Stage, watch: Watch) -> None:
    """Whoever drives is back at once where their own address has spent all that it may ask."""
    browser = Browser()
    await watch.operator.leave()
    async with AsyncExitStack() as here:
        driving = await here.enter_async_context(RawOperator(stage.server, browser=browser))
        await driving.join()
        refused = asyncio.Event()
        flood = asyncio.create_task(_offers_nothing(stage.server, refused))
        here.callback(flood.cancel)
        await refused.wait()
        for _ in range(2):
            turn = driving.turn
            await driving.close()
            driving = await here.enter_async_context(RawOperator(stage.server, browser=browser))
            await driving.gets_turn()
            assert driving.turn == turn
        await driving.leave()
    await watch.operator.join()


async def _offers_nothing(server: Server, refused: asyncio.Event) -> None:
    """Let 127.0.0.1 spend all that it may ask, and go on."""
    while True:
        empty = {"sdp": "", "client": str(uuid.uuid4())}
        if (await ask(server.port, "POST", "/api/offer", body=empty)).status == 429:
            refused.set()


# --- rules of the room, with a server of its own --------------------------------------------

STOPS: Final = 2
RULES: Final[dict[str, Any]] = {
    "server": {"trusted_proxies": ["127.0.0.1"]},
    "access": {"strangers_queue": False},
    "turns": {"join": "auto", "turn_s": 5.0, "max_waiting_per_address": 2},
    "stop": {"max_per_minute_per_address": STOPS},
    "video": {"source": "testcard"},
    "audio": {"source": "none"},
}


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def strict(
    configuration: tuple[Mapping[str, Any], Load],
    serve: Serve,
    tmp_path_factory: pytest.TempPathFactory,
) -> AsyncIterator[Server]:
    """Have a server whose strangers only watch, behind a proxy that says where they come from."""
    rules = toml.dumps(toml.merged(configuration[0], RULES))
    async with serve(tmp_path_factory.mktemp("strict"), rules) as running:
        yield running


async def _places(server: Server) -> list[dict[str, Any]]:
    """Return who drives or waits."""
    status = await server.status()
    return [one for one in status["viewers"] if one["role"] != "observer"]


async def test_no_way_in_gives_a_place_that_is_forbidden(strict: Server) -> None:
    """Neither by coming, nor by asking on the channel or by HTTP, where strangers may not queue."""
    async with Intruder(strict.port) as stranger:
        stranger.say(type="join")
        asked = await stranger.post("/api/queue", wants="join")
        assert asked.status == 403
        assert await _places(strict) == []
        assert stranger.told["room"]["turn"]["operator"] is None


async def test_a_refused_request_keeps_no_place(strict: Server) -> None:
    """Twelve strangers who were told no are not in the room afterwards."""
    before = len((await strict.status())["viewers"])
    for _ in range(12):
        answer = await _wants_to_wait(strict)
        assert answer.status == 403, answer.body
    assert len((await strict.status())["viewers"]) == before
    assert await _places(strict) == []


async def _wants_to_wait(server: Server, source: str = "127.0.0.1") -> Answer:
    body = {"client": str(uuid.uuid4()), "wants": "join"}
    return await ask(server.port, "POST", "/api/queue", source=source, body=body)


async def test_new_cookies_of_one_address_press_stop_as_one(strict: Server) -> None:
    """As many of five who have just come as their address may; somebody elsewhere still may."""
    async with AsyncExitStack() as leaving:
        crowd = [Intruder(strict.port, source=address(220)) for _ in range(5)]
        for one in (*crowd, other := Intruder(strict.port, source=address(221))):
            await leaving.enter_async_context(one)
        pressed = [(await one.post("/api/stop")).status for one in crowd]
        assert set(pressed) == {200, 403}
        assert pressed.count(200) <= STOPS
        assert (await other.post("/api/stop")).status == 200


@pytest.mark.parametrize("proxied", ["198.51.100.7", "127.0.0.1"])
async def test_two_headers_that_differ_are_no_request(strict: Server, proxied: str) -> None:
    """A client that says `Forwarded` beside the proxy's own header is somebody else nowhere."""
    headers = [("X-Forwarded-For", "198.51.100.66"), ("Forwarded", f"for={proxied}")]
    assert (await ask(strict.port, "GET", "/healthz", headers=headers)).status == 400
    alone = await ask(strict.port, "GET", "/healthz", headers=headers[:1])
    assert alone.status == 200


async def test_waiting_by_http_is_for_those_who_watch_elsewhere(stage: Stage) -> None:
    """Without rooms nobody waits by HTTP alone, and no turn begins for somebody who is not here."""
    before = len((await stage.server.status())["viewers"])
    answers = [await _wants_to_wait(stage.server, address(210)) for _ in range(20)]
    assert {answer.status for answer in answers} <= {403, 409, 429}, answers[0].body
    assert len((await stage.server.status())["viewers"]) == before
