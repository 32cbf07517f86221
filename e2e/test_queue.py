"""Two people, one robot, turns of three seconds."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.robot import moves, stands_still, turn_by_key, undisturbed
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

TURN_S = 3.0


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    short = toml.card_with(turns=f"turn_s = {TURN_S}\n{toml.BRIEF_GRACE}")
    async with serve(tmp_path_factory.mktemp("queue"), short) as running:
        yield running


@pytest_asyncio.fixture(autouse=True, loop_scope="session")
async def _nobody_is_left(server: Server) -> None:
    """Wait for those of the test before.

    A page that was killed before it said goodbye keeps place and name for a while.
    """

    async def is_empty() -> bool:
        return not (await server.status())["viewers"]

    await eventually(is_empty, "those of the test before are gone", within_s=20)


async def person(open_viewer: OpenViewer, server: Server, name: str) -> Viewer:
    viewer = await open_viewer(server)
    await viewer.call_oneself(name)
    return viewer


async def listed(server: Server, name: str) -> dict[str, Any]:
    """Return the server's line of this person, empty when not (yet) there."""
    viewers = (await server.status())["viewers"]
    return next((line for line in viewers if line["name"] == name), {})


async def operator(server: Server) -> str | None:
    viewers = (await server.status())["viewers"]
    driving = [line["name"] for line in viewers if line["role"] == "operator"]
    assert len(driving) <= 1, f"two people drive: {driving}"
    return driving[0] if driving else None


async def is_driven_by(server: Server, name: str, within_s: float) -> None:
    async def so() -> bool:
        return await operator(server) == name

    await eventually(so, f"{name} drives", within_s=within_s)


@pytest.mark.timeout(90)
async def test_everyone_is_listed_with_their_place(server: Server, open_viewer: OpenViewer) -> None:
    """The list shows who drives, who waits at which place and for how long, and who watches."""
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await person(open_viewer, server, "Cleo")
    await ada.join()
    await ada.drives()
    await bob.join()

    async def complete() -> bool:
        lines = await bob.queue.get_by_role("listitem").all_inner_texts()
        text = " | ".join(lines)
        return (
            len(lines) == 3
            and all(name in text for name in ("Ada", "Bob", "Cleo"))
            and re.search(r"watch", text, re.IGNORECASE) is not None
        )

    await eventually(complete, "all three are in the list", within_s=5)
    assert {(await listed(server, "Cleo"))["role"]} == {"observer"}


@pytest.mark.timeout(90)
async def test_the_turn_passes_on_when_it_ends(server: Server, open_viewer: OpenViewer) -> None:
    """After their turn the operator goes to the end of the queue; the next viewer drives."""
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await ada.join()
    await ada.drives()
    await bob.join()
    before = (await server.status())["turn"]["number"]
    await bob.drives(within_s=TURN_S + 2)
    assert await operator(server) == "Bob"
    assert (await server.status())["turn"]["number"] > before
    waiting = await listed(server, "Ada")
    assert (waiting["role"], waiting["place"]) == ("queued", 1)
    await ada.page.get_by_text("You are driving").first.wait_for(state="hidden", timeout=1000)
    await ada.drives(within_s=TURN_S + 2)


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_the_timer_counts_down(server: Server, open_viewer: OpenViewer) -> None:
    """The operator sees the turn's remaining seconds, falling and never above its length."""
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await ada.join()
    await ada.drives()
    await bob.join()
    await bob.drives(within_s=TURN_S + 2)
    seen: list[int] = []
    for _ in range(5):
        number = re.search(r"\d+", await bob.timer.first.inner_text())
        assert number is not None, "no number on the timer"
        seen.append(int(number.group()))
        await asyncio.sleep(0.5)
    assert seen == sorted(seen, reverse=True), seen
    assert max(seen) <= TURN_S
    assert len(set(seen)) >= 2, seen


@pytest.mark.timeout(90)
async def test_the_robot_stops_when_the_operator_changes(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A key still held at the end of the turn moves nothing in the next one's turn."""
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await ada.join()
    await ada.drives()
    await bob.join()
    await turn_by_key(server, ada)
    await is_driven_by(server, "Bob", within_s=TURN_S + 2)
    assert await stands_still(server, after_s=0.3)


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_alone_the_turn_renews_without_a_break(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Alone in the queue, a turn renews without a break in driving."""
    ada = await person(open_viewer, server, "Ada")
    await ada.join()
    await ada.drives()

    async def breaks() -> int:
        await turn_by_key(server, ada)
        moved = [await moves(server, during_s=0.4) for _ in range(int(TURN_S * 1.5 / 0.4))]
        await ada.page.keyboard.up("ArrowLeft")
        return moved.count(False)

    assert await undisturbed(server, breaks) == 0


@pytest.mark.timeout(90)
async def test_leaving_hands_over_at_once(server: Server, open_viewer: OpenViewer) -> None:
    """When the operator leaves the queue, the next one drives without waiting for the end."""
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await ada.join()
    await ada.drives()
    await bob.join()
    await ada.leave()
    await is_driven_by(server, "Bob", within_s=1)
    assert (await listed(server, "Ada"))["role"] == "observer"


@pytest.mark.timeout(90)
async def test_a_name_is_text_and_bounded(server: Server, open_viewer: OpenViewer) -> None:
    """A name with markup is shown as it was typed, trimmed and cut, and is not executed."""
    ada = await person(open_viewer, server, "  <img src=x onerror=alert(1)>" + "x" * 60)
    other = await open_viewer(server)

    async def shown() -> bool:
        text = await other.queue.inner_text()
        return "<img src=x" in text

    await eventually(shown, "the name is listed", within_s=5)
    assert await other.queue.locator("img").count() == 0
    names = [line["name"] for line in (await server.status())["viewers"]]
    assert all(len(name) <= 24 and name == name.strip() for name in names), names
    assert await ada.queue.locator("img").count() == 0
