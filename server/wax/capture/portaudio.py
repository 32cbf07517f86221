"""PortAudio, of which a process has one: loading it, and looking for its devices again."""

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
"""The open streams of this process, which PortAudio itself does not tell."""


def load_portaudio(what: Sentence = MICROPHONES, instead: str = '[audio] source = "none"') -> Any:
    """Import `sounddevice`, which needs the PortAudio library; raises `SourceError`.

    `what` needs it, and `instead` is what to set where it cannot be had.
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


def sought(device: int | str | None) -> int | str | None:
    """Return what PortAudio finds a device by: of a link to a sound card the card's number now.

    udev names cards by their sockets, the only difference between two that are alike.
    """
    if not isinstance(device, str) or not device.startswith(f"{SOUND_CARDS}/"):
        return device
    card = re.fullmatch(r"controlC(\d+)", Path(device).resolve().name)
    return f"hw:{card[1]}," if card else device


def begin(stream: Any) -> Any:
    """Start a stream and return it; one that does not start is closed."""
    try:
        stream.start()
    except BaseException:
        stream.close(ignore_errors=True)
        raise
    _in_use.add(id(stream))
    return stream


def end(stream: Any) -> None:
    """Close a stream at once, if there is one; what it still has to play is lost."""
    if stream is not None:
        stream.abort(ignore_errors=True)
        stream.close(ignore_errors=True)
        _in_use.discard(id(stream))


def look_for_new_devices(portaudio: Any) -> None:
    """Make PortAudio list its devices again, which it does only when it starts.

    There is no public function for that. It ends all streams of the process, so it is left out
    while one is open: a microphone that fails must not end the speaker, nor the other way round.
    """
    if _in_use:
        return
    portaudio._terminate()
    portaudio._initialize()


def telling_part(error: Exception) -> str:
    """Return the part of PortAudio's errors that says something to people.

    Of a name that fits several devices that is all: the devices follow, each in a line.
    """
    first, *others = str(error).strip().splitlines() or [type(error).__name__]
    if not isinstance(error, ValueError) or not others:
        return first
    return f"{first} {'; '.join(others)}"[:_MAX_CHARS]
