"""What people read about a stream that does not open, from programs that really fail this way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from av.error import ExitError
from tests.free_port import free_port
from tests.tls_server import pair, server_context, serving

from wax.capture.file.address import open_container
from wax.capture.file.not_opened import not_opened, stopped
from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from pathlib import Path

NETWORK = ("http", "https", "rtsp", "rtsps", "rtmp", "tcp")
TIME_IS_OVER = ExitError(1, "Immediate exit requested")


def _said(address: str) -> Sentence:
    with pytest.raises(SourceError) as caught:
        open_container(address)
    return caught.value.sentence


def _why(said: Sentence) -> str:
    why = said.values["why"]
    assert isinstance(why, Sentence)
    return why.code.removeprefix("unreachable.")


@pytest.mark.parametrize("scheme", NETWORK)
def test_a_port_that_nobody_has(scheme: str) -> None:
    """For a closed port the sentence is the same in every protocol: the camera may be in use."""
    said = _said(f"{scheme}://127.0.0.1:{free_port()}/x")
    assert (said.code, _why(said)) == ("file.perhaps_taken", "nobody")


@pytest.mark.parametrize("scheme", ["http", "rtsp", "rtmp"])
def test_one_that_hangs_up_may_serve_another(scheme: str) -> None:
    """A closed connection, for which FFmpeg has three errors, may mean a camera in use."""
    with serving(None) as port:
        said = _said(f"{scheme}://127.0.0.1:{port}/x")
    assert (said.code, _why(said)) == ("file.perhaps_taken", "closed")
    assert "many cameras serve one client at a time" in str(said)


@pytest.mark.parametrize("scheme", NETWORK[:-1])
def test_a_name_that_there_is_not_is_no_camera_that_is_taken(scheme: str) -> None:
    """FFmpeg's input/output error for an unknown host becomes a sentence about the name."""
    said = _said(f"{scheme}://nowhere.invalid/x")
    assert said.code == "file.not_reached"
    assert _why(said) in ("no_name", "no_name_server")


@pytest.mark.parametrize("scheme", ["https", "rtsps"])
def test_a_plain_port_that_is_spoken_to_by_tls(scheme: str) -> None:
    """The sentence blames the address when TLS meets a plain port."""
    with serving(None) as port:
        said = _said(f"{scheme}://127.0.0.1:{port}/x")
    assert (said.code, _why(said)) == ("file.not_reached", "no_tls")


@pytest.mark.parametrize("scheme", ["http", "rtsp"])
def test_an_encrypted_port_that_is_spoken_to_in_plain_text(tmp_path: Path, scheme: str) -> None:
    """The sentence names the right scheme when plain text meets a TLS port."""
    with serving(server_context(pair(tmp_path))) as port:
        said = _said(f"{scheme}://127.0.0.1:{port}/x")
    assert (said.code, _why(said)) == ("file.not_reached", "tls")
    assert f"write {scheme}s://" in str(said)


def test_what_comes_by_no_connection_delivers_nothing() -> None:
    """An address over UDP, which cannot be probed, is called silent, as is a stream that stalls."""
    silent = Sentence("file.silent", {"name": "cam"})
    assert not_opened("cam", None, TIME_IS_OVER, is_late=True) == silent
    assert stopped("cam", TIME_IS_OVER) == silent
    taken = not_opened("cam", None, OSError(22, "Invalid argument"), is_late=False)
    assert str(taken) == "cam cannot be opened. Invalid argument."
