"""Two people, one robot, turns of three seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from e2e.harness import toml
from e2e.harness.robot import moves, nothing_is_held, stands_still
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SERVER_SETTINGS = toml.card_with(turns="turn_s = 3.0")


async def person(open_viewer: OpenViewer, server: Server, name: str) -> Viewer:
    viewer = await open_viewer(server)
    await viewer.call_oneself(name)
    return viewer


def listed(status: dict[str, Any], name: str) -> dict[str, Any]:
    """Return the server's entry for this person, empty while there is none."""
    return next((line for line in status["viewers"] if line["name"] == name), {})


def operator(status: dict[str, Any]) -> str | None:
    driving = [line["name"] for line in status["viewers"] if line["role"] == "operator"]
    assert len(driving) <= 1, f"two people drive: {driving}"
    return driving[0] if driving else None


@pytest.mark.timeout(90)
async def test_turns_pass_on_and_the_robot_stands_between_them(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Each drives in turn, and a control held at the end of a turn moves nothing in the next."""
    ada = await person(open_viewer, server, "Ada")
    bob = await person(open_viewer, server, "Bob")
    await ada.takes_the_wheel()
    await bob.join()

    def bobs_turn(told: dict[str, Any]) -> int:
        """Return the turn's number once Bob drives while Ada waits: each gets another turn."""
        ada_s = listed(told, "Ada")
        is_so = (operator(told), ada_s["role"], ada_s["place"]) == ("Bob", "queued", 1)
        return int(told["turn"]["number"]) if is_so else 0

    number = await server.until(bobs_turn, "Bob drives next, and Ada waits for him")
    await bob.drives()
    await ada.page.get_by_text("You are driving").first.wait_for(state="hidden")

    async def turns_in_hers() -> bool:
        """Hold a key in a turn of Ada's, which may end before the robot moves."""
        await ada.page.keyboard.up("ArrowLeft")
        await ada.drives()
        await nothing_is_held(server)
        await ada.page.keyboard.down("ArrowLeft")
        return await moves(server, within_s=1)

    await eventually(turns_in_hers, "Ada turns the robot", within_s=30)
    assert (await server.status())["turn"]["number"] > number
    await server.until(lambda told: operator(told) == "Bob", "Bob drives")
    assert await stands_still(server)
    await ada.page.keyboard.up("ArrowLeft")
