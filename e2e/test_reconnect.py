"""What a reload does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.harness import toml
from e2e.harness.robot import moves, nothing_is_held, stands_still, turn_by_key
from e2e.harness.viewer import LEAVE

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve

pytestmark = pytest.mark.timeout(90)

PATIENT = toml.card_with(turns="grace_s = 20.0")
"""A busy machine takes long to reopen a page."""


async def test_a_reload_keeps_turn_place_and_name(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """An operator who reloads drives on in the same turn, but only by a new press."""
    async with serve(tmp_path, PATIENT) as server:
        ada, bob = await open_viewer(server), await open_viewer(server)
        await ada.call_oneself("Ada")
        await bob.call_oneself("Bob")
        await ada.takes_the_wheel()
        await bob.join()
        await bob.page.get_by_role("button", name=LEAVE).wait_for()
        number = (await server.status())["turn"]["number"]
        await turn_by_key(server, ada)
        await ada.page.reload()
        assert await stands_still(server)
        await bob.page.reload()
        for viewer in (ada, bob):
            await viewer.sees_picture()
        await ada.drives()
        await bob.page.get_by_role("button", name=LEAVE).wait_for()
        await nothing_is_held(server)  # so that only the key's own release is missing
        assert not await moves(server, within_s=0.5)
        after = await server.status()
        assert after["turn"]["number"] == number
        roles = {line["name"]: (line["role"], line["place"]) for line in after["viewers"]}
        assert roles == {"Ada": ("operator", 0), "Bob": ("queued", 1)}
        await ada.page.keyboard.up("ArrowLeft")
        await turn_by_key(server, ada)
        await ada.page.keyboard.up("ArrowLeft")
