"""Loads PortAudio (one instance per process), starts its streams and rescans its devices."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any, Final

from wax.errors import SourceError
from wax.sentence import Sentence

MICROPHONES: Final = Sentence("portaudio.microphones")
SOUND_CARDS: Final = Path("/dev/snd")
_MAX_CHARS: Final = 300
_in_use: Final[set[int]] = set()
"""The open streams of this process, which PortAudio does not report."""


def load_portaudio(what: Sentence = MICROPHONES, instead: str = '[audio] source = "none"') -> Any:
    """Import `sounddevice`, which needs the PortAudio library; raises `SourceError`.

    In the message, `what` needs it, and `instead` is what to configure where it is unavailable.
    """
    try:
        return importlib.import_module("sounddevice")
    except OSError as error:
        raise SourceError(
            Sentence("portaudio.no_library", {"what": what, "instead": instead})
        ) from error
    except ImportError as error:
        raise SourceError(
            Sentence("portaudio.no_package", {"what": what, "instead": instead})
        ) from error


def portaudio_name(device: int | str | None) -> int | str | None:
    """Return what PortAudio knows a device by; a link to a sound card becomes its current number.

    udev's links name cards by socket, the only difference between two identical ones.
    """
    if not isinstance(device, str) or not device.startswith(f"{SOUND_CARDS}/"):
        return device
    card = re.fullmatch(r"controlC(\d+)", Path(device).resolve().name)
    return f"hw:{card[1]}," if card else device


def start_stream(stream: Any) -> Any:
    """Start a stream and return it; close it if it does not start."""
    try:
        stream.start()
    except BaseException:
        stream.close(ignore_errors=True)
        raise
    _in_use.add(id(stream))
    return stream


def close_stream(stream: Any) -> None:
    """Close a stream at once, if there is one; sound that it has not played yet is lost."""
    if stream is not None:
        stream.abort(ignore_errors=True)
        stream.close(ignore_errors=True)
        _in_use.discard(id(stream))


def rescan_devices(portaudio: Any) -> None:
    """Make PortAudio list its devices again, which it otherwise does only when it starts.

    There is no public function for that. Restarting ends all streams of the process, so nothing is
    done while one is open: a microphone that fails must not end the speaker, nor vice versa.
    """
    if _in_use:
        return
    portaudio._terminate()
    portaudio._initialize()


def readable_part(error: Exception) -> str:
    """Return the part of one of PortAudio's errors that helps a person.

    That is its first line; all of them for a name that fits several devices, which they list.
    """
    first, *others = str(error).strip().splitlines() or [type(error).__name__]
    if not isinstance(error, ValueError) or not others:
        return first
    return f"{first} {'; '.join(others)}"[:_MAX_CHARS]
