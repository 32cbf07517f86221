"""The questions of `wax init`: at most five, each with a default. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.commands.init.found import Found, Thing

Key = Literal["robot", "camera", "microphone", "speaker", "who"]

THIS_MACHINE = "localhost"
NETWORK = "0.0.0.0"  # the host chooses it
ANYWHERE = "door"


@dataclass(frozen=True, slots=True)
class Choice:
    """One answer: `value` is what is written, `says` what people read."""

    value: str
    says: str


@dataclass(frozen=True, slots=True)
class Question:
    """The first choice is the default."""

    key: Key
    asks: str
    choices: tuple[Choice, ...]


@dataclass(frozen=True, slots=True)
class Answers:
    """The answers, as values to write; `port` is empty unless the driver is the serial one."""

    driver: str
    port: str
    camera: str
    microphone: str
    speaker: str
    host: str


def robot(found: Found, port: str | None) -> Question:
    """Return the question which robot it is; `port`, if given, is the default."""
    boards = [Choice(f"serial {one.source}", _board(one)) for one in found.ports]
    if port is not None:
        boards.insert(0, Choice(f"serial {port}", f"the board on {port}"))
    plug_ins = [Choice(name, f"by the driver {name}") for name in found.drivers]
    simulated = Choice("simulated", "a simulated one, to try it out")
    first = port is not None or found.plugged > 0
    choices = [*boards, simulated, *plug_ins] if first else [simulated, *boards, *plug_ins]
    return Question("robot", "Which robot?", tuple(choices))


def others(found: Found, driver: str) -> Iterator[Question]:
    """Yield the other questions; they depend on whether the robot has its own camera and sound."""
    own = (Choice("robot", "the robot's own"),) if driver == "simulated" else ()
    auto = {
        "simulated": (),
        "serial": (Choice("auto", "the first that is found"),),
    }.get(driver, (Choice("auto", "the robot's own, or the first that is found"),))
    cameras = tuple(Choice(one.source, _named(one)) for one in found.cameras)
    # A board has no camera: the one that is there is named, so that it stays the same one when
    # another is plugged in.
    named_first = driver == "serial"
    yield Question(
        "camera",
        "By which camera is it driven?",
        (
            *own,
            *((*cameras, *auto) if named_first else (*auto, *cameras)),
            Choice("testcard", "a test card"),
        ),
    )
    microphones = tuple(Choice(one.source, _named(one)) for one in found.microphones)
    yield Question(
        "microphone",
        "Which microphone is heard?",
        (*own, *auto, *microphones, Choice("none", "none")),
    )
    speakers = tuple(Choice(one.source, _named(one)) for one in found.speakers)
    if own or speakers:
        yield Question(
            "speaker",
            "May whoever drives speak to the people beside it, and by which speaker?",
            (Choice("none", "no"), *own, *speakers),
        )
    yield Question(
        "who",
        "Who can open the page?",
        (
            Choice(THIS_MACHINE, "this machine only"),
            Choice(NETWORK, "every device in this network, by HTTPS"),
            Choice(
                ANYWHERE, "people anywhere, through a door (you paste the line that it printed)"
            ),
        ),
    )


def answers(given: dict[Key, str]) -> Answers:
    """Return the choices as values to write."""
    driver, _, port = given["robot"].partition(" ")
    return Answers(
        driver=driver,
        port=port,
        camera=given["camera"],
        microphone=given["microphone"],
        speaker=given.get("speaker", "none"),
        host=THIS_MACHINE if given["who"] == ANYWHERE else given["who"],
    )


def _board(port: Thing) -> str:
    return f"the board on {_named(port)}"


def _named(thing: Thing) -> str:
    return f"{thing.source} ({thing.name})" if thing.name else thing.source
