"""Two people, one robot, turns of three seconds."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING, Any

import pytest

from e2e.harness import toml
from e2e.harness.robot import moves, stands_still, turn_by_key, undisturbed
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

TURN_S = 3.0


SERVER_SETTINGS = toml.card_with(turns=f"turn_s = {TURN_S}\n{toml.BRIEF_GRACE}")


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
async def test_turns_pass_on_and_the_robot_stands_between_them(
    server: Server, open_viewer: OpenViewer
) -> None:
    """All are listed; the timer falls to the end of a turn, a held key ends with it, and the next
    one drives, at once where somebody leaves.
    """
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await person(open_viewer, server, "<b>Cleo")
    await ada.takes_the_wheel()
    await bob.join()

    async def complete() -> bool:
        lines = await bob.queue.get_by_role("listitem").all_inner_texts()
        text = " | ".join(lines)
        return (
            len(lines) == 3
            and all(name in text for name in ("Ada", "Bob", "<b>Cleo"))
            and re.search(r"watch", text, re.IGNORECASE) is not None
        )

    await eventually(complete, "all three are in the list", within_s=5)
    assert (await listed(server, "<b>Cleo"))["role"] == "observer"
    await bob.drives(within_s=TURN_S + 2)
    number = (await server.status())["turn"]["number"]
    waiting = await listed(server, "Ada")
    assert (waiting["role"], waiting["place"]) == ("queued", 1)
    await ada.page.get_by_text("You are driving").first.wait_for(state="hidden", timeout=1000)
    seen = [await seconds_left(bob)]
    await asyncio.sleep(1.1)
    seen.append(await seconds_left(bob))
    assert TURN_S >= seen[0] > seen[1], seen

    await ada.drives(within_s=TURN_S + 2)
    assert (await server.status())["turn"]["number"] > number
    await turn_by_key(server, ada)
    await is_driven_by(server, "Bob", within_s=TURN_S + 2)
    assert await stands_still(server, after_s=0.3)
    await ada.page.keyboard.up("ArrowLeft")

    await ada.drives(within_s=TURN_S + 2)
    await ada.leave()
    await is_driven_by(server, "Bob", within_s=1)
    assert (await listed(server, "Ada"))["role"] == "observer"


async def seconds_left(viewer: Viewer) -> int:
    number = re.search(r"\d+", await viewer.timer.first.inner_text())
    assert number is not None, "no number on the timer"
    return int(number.group())


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_alone_the_turn_renews_without_a_break(server: Server, driver: Viewer) -> None:
    """Alone in the queue, a turn renews without a break in driving."""

    async def breaks() -> int:
        await turn_by_key(server, driver)
        moved = [await moves(server, during_s=0.4) for _ in range(int(TURN_S * 1.5 / 0.4))]
        await driver.page.keyboard.up("ArrowLeft")
        return moved.count(False)

    assert await undisturbed(server, breaks) == 0
