"""What is said of a stream that does not open, by programs that really fail so."""

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
    """It is one, by whatever protocol; a camera that serves one client may close it, too."""
    said = _said(f"{scheme}://127.0.0.1:{free_port()}/x")
    assert (said.code, _why(said)) == ("file.perhaps_taken", "nobody")


@pytest.mark.parametrize("scheme", ["http", "rtsp", "rtmp"])
def test_one_that_hangs_up_may_serve_another(scheme: str) -> None:
    """FFmpeg calls it by three names, one of them invalid data."""
    with serving(None) as port:
        said = _said(f"{scheme}://127.0.0.1:{port}/x")
    assert (said.code, _why(said)) == ("file.perhaps_taken", "closed")
    assert "many cameras serve one client at a time" in str(said)


@pytest.mark.parametrize("scheme", NETWORK[:-1])
def test_a_name_that_there_is_not_is_no_camera_that_is_taken(scheme: str) -> None:
    """FFmpeg calls it an input/output error."""
    said = _said(f"{scheme}://nowhere.invalid/x")
    assert said.code == "file.not_reached"
    assert _why(said) in ("no_name", "no_name_server")


@pytest.mark.parametrize("scheme", ["https", "rtsps"])
def test_a_plain_port_that_is_spoken_to_by_tls(scheme: str) -> None:
    """The address is what is wrong."""
    with serving(None) as port:
        said = _said(f"{scheme}://127.0.0.1:{port}/x")
    assert (said.code, _why(said)) == ("file.not_reached", "no_tls")


@pytest.mark.parametrize("scheme", ["http", "rtsp"])
def test_an_encrypted_port_that_is_spoken_to_in_plain_text(tmp_path: Path, scheme: str) -> None:
    """The right scheme is named."""
    with serving(server_context(pair(tmp_path))) as port:
        said = _said(f"{scheme}://127.0.0.1:{port}/x")
    assert (said.code, _why(said)) == ("file.not_reached", "tls")
    assert f"write {scheme}s://" in str(said)


def test_what_comes_by_no_connection_delivers_nothing() -> None:
    """By UDP there is nobody to look at; the same is said where a stream falls silent."""
    silent = Sentence("file.silent", {"name": "cam"})
    assert not_opened("cam", None, TIME_IS_OVER, is_late=True) == silent
    assert stopped("cam", TIME_IS_OVER) == silent
    taken = not_opened("cam", None, OSError(22, "Invalid argument"), is_late=False)
    assert str(taken) == "cam cannot be opened. Invalid argument."
