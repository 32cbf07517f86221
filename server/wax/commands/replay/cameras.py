"""Which cameras other than the driving view can be shown with a part, and from which time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.protocol.tape_events import Filmed, Placed, TapeCamera
from wax.tape.repaired import facts_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.tape.shelf import Shelved

_UNPLACED: Final = "What camera {number} showed is left out: the events do not say when it began."
_ABSENT: Final = "What the camera {name} showed is not beside this."
_DAMAGED: Final = "The camera {name} is left out. {why}"


def cameras_of(part: Shelved, events: Sequence[Placed]) -> tuple[list[TapeCamera], str | None]:
    """Return the cameras in order, and a sentence about any that is left out.

    Raises `StateError` for a file that is too large to be a part of a tape.
    """
    found: dict[int, TapeCamera] = {}
    problems: list[str] = []
    for placed in events:
        event = placed.event
        if not isinstance(event, Filmed) or event.camera in found:
            continue
        path = part.cameras.get(event.camera)
        if path is None:
            problems.append(_ABSENT.format(name=event.name))
            continue
        why = facts_of(path).problem
        if why is not None:
            problems.append(_DAMAGED.format(name=event.name, why=why))
            continue
        found[event.camera] = TapeCamera(
            number=event.camera, name=event.name, began_ms=placed.at_ms
        )
    filmed = {one.event.camera for one in events if isinstance(one.event, Filmed)}
    problems += [_UNPLACED.format(number=one) for one in sorted(part.cameras.keys() - filmed)]
    return [found[number] for number in sorted(found)], next(iter(problems), None)
