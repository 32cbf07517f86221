"""The Unix socket that gives out host links."""

from __future__ import annotations

import asyncio
import stat
from typing import TYPE_CHECKING

import pytest

from wax.access.host_link import SOCKET, HostLinkSocket, request_links
from wax.errors import StateError

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("folder", ["state", "x" * 60 + "/" + "y" * 60])
async def test_who_may_use_the_folder_gets_a_link(tmp_path: Path, folder: str) -> None:
    """The folder's owner alone gets a new link each time, even by a path too long for a socket."""
    made = [f"http://localhost/#host={number}" for number in range(3)]
    served = HostLinkSocket(str(tmp_path / folder), lambda: [made.pop(0), "http://192.0.2.1/"])
    await served.open()
    assert served.is_open
    mode = (tmp_path / folder / SOCKET).stat().st_mode
    assert stat.S_ISSOCK(mode)
    assert mode & 0o777 == 0o600
    for number in range(2):
        links = await asyncio.to_thread(request_links, tmp_path / folder)
        assert links == [f"http://localhost/#host={number}", "http://192.0.2.1/"]
    await served.close()
    with pytest.raises(StateError, match=r"answers \(No such .*is it running"):
        request_links(tmp_path / folder)


async def test_a_socket_that_a_killed_server_left_is_replaced(tmp_path: Path) -> None:
    """A server replaces the socket that a killed one left behind."""
    first = HostLinkSocket(str(tmp_path), lambda: ["old"])
    await first.open()
    second = HostLinkSocket(str(tmp_path), lambda: ["new"])
    await second.open()
    assert await asyncio.to_thread(request_links, tmp_path) == ["new"]
    await second.close()
    await first.close()


async def test_without_a_folder_the_server_runs(tmp_path: Path) -> None:
    """Without a usable state folder, the server warns and has no socket; `close` is safe."""
    (tmp_path / "file").write_text("")
    for state in (str(tmp_path / "file" / "x"), "~nobody-of-this-name/wax"):
        served = HostLinkSocket(state, list)
        await served.open()
        assert not served.is_open
        await served.close()
