"""The socket that hands out host links."""

from __future__ import annotations

import asyncio
import stat
from typing import TYPE_CHECKING

import pytest

from wax.access.host_link import SOCKET, HostLinkSocket, ask
from wax.errors import StateError

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("folder", ["state", "x" * 60 + "/" + "y" * 60])
async def test_who_may_use_the_folder_gets_a_link(tmp_path: Path, folder: str) -> None:
    """Each time a new one, also where the path is longer than a socket's may be; never another."""
    made = [f"http://localhost/#host={number}" for number in range(3)]
    served = HostLinkSocket(str(tmp_path / folder), lambda: [made.pop(0), "http://192.0.2.1/"])
    await served.open()
    assert served.is_open
    mode = (tmp_path / folder / SOCKET).stat().st_mode
    assert stat.S_ISSOCK(mode)
    assert mode & 0o777 == 0o600
    for number in range(2):
        links = await asyncio.to_thread(ask, tmp_path / folder)
        assert links == [f"http://localhost/#host={number}", "http://192.0.2.1/"]
    await served.close()
    with pytest.raises(StateError, match="is it running"):
        ask(tmp_path / folder)


async def test_a_socket_that_a_killed_server_left_is_replaced(tmp_path: Path) -> None:
    """The next server takes its place."""
    first = HostLinkSocket(str(tmp_path), lambda: ["old"])
    await first.open()
    second = HostLinkSocket(str(tmp_path), lambda: ["new"])
    await second.open()
    assert await asyncio.to_thread(ask, tmp_path) == ["new"]
    await second.close()
    await first.close()


async def test_without_a_folder_the_server_runs(tmp_path: Path) -> None:
    """It warns, also where there is no home; nobody is told to ask; `close` is safe."""
    (tmp_path / "file").write_text("")
    for state in (str(tmp_path / "file" / "x"), "~nobody-of-this-name/wax"):
        served = HostLinkSocket(state, list)
        await served.open()
        assert not served.is_open
        await served.close()
