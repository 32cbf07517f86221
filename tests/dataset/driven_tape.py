"""A tape of the test card, on which somebody drove, written faster than it would be driven."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Literal

from tests.capture.card_reader import read_stamp
from tests.tape.packets import sounds
from tests.turned_clock import TurnedClock

from wax.capture.source import Picture
from wax.capture.testcard import STAMP_MODULUS, TestCardVideo
from wax.config.settings import Settings
from wax.config.video import RenditionSettings
from wax.encode.encoded import EncodedSound
from wax.encode.video_encoder import VideoEncoder
from wax.protocol.tape_events import Commanded, Reported, Steered, Turned
from wax.tape.segment import Segment

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np

    from wax.protocol.tape_events import TapeEvent
    from wax.tape.shelf import Shelf

    Timed = tuple[float, TapeEvent]

SIZE: Final = (160, 120)
FPS: Final = 20
BEGAN_S: Final = 1_795_442_400.0
"""When time 0 of the tape was, in seconds since 1970."""


def steered(linear_mps: float, angular_rps: float = 0.0, **more: object) -> Steered:
    """Return a set-point that was sent as it was wanted, in turn 1."""
    known = {"turn": 1, "reason": None, "limit": None} | more
    sent = {"linear_mps": linear_mps, "angular_rps": angular_rps}
    return Steered.model_validate(known | sent | {f"wanted_{key}": of for key, of in sent.items()})


def reported(x_m: float | None = 0.0, **more: object) -> Reported:
    """Return a report of a robot that knows where it is, and its battery."""
    known = {"connected": True, "problem": None, "moving": True, "y_m": 0.0, "heading_rad": 0.0}
    return Reported.model_validate(known | {"x_m": x_m, "battery_v": 12.0} | more)


def commanded(*, held: bool, refused: str | None = None) -> Commanded:
    return Commanded(
        viewer=1,
        seq=1,
        turn=1,
        age_ms=10.0,
        seen_age_ms=None,
        linear=0.0,
        angular=0.0,
        held=held,
        speed="fast",
        axes={},
        refused=refused,
    )


def turned(number: int, operator: int | None = 1) -> Turned:
    return Turned(number=number, operator=operator, why=None if operator else "given up")


def write_part(
    shelf: Shelf,
    events: Sequence[Timed],
    times_s: Sequence[float],
    *,
    codec: Literal["vp8", "h264"] = "vp8",
    size: tuple[int, int] = SIZE,
    is_keyframe: Callable[[int], bool] = lambda number: number % (10 * FPS) == 0,
    has_sound: bool = False,
    has_end: bool = True,
) -> Segment:
    """Write a part that begins with the first picture; all times are seconds of the tape."""
    width, height = size
    rendition = RenditionSettings(width=width, height=height, fps=FPS, bitrate_bps=400_000)
    settings = Settings.model_validate({"video": {"width": width, "height": height}}).video
    card, encoder = (
        TestCardVideo(settings, TurnedClock()),
        VideoEncoder(codec=codec, rendition=rendition),
    )
    card.open()
    part = Segment(
        shelf,
        origin_s=times_s[0],
        zero_ns=round(BEGAN_S * 1e9),
        codec=codec,
        size=size,
        has_sound=has_sound,
    )
    items: list[tuple[float, TapeEvent | EncodedSound | int]] = [
        *events,
        *((one.captured_s, one) for one in _heard(times_s) if has_sound),
        *((at_s, number) for number, at_s in enumerate(times_s)),
    ]
    for at_s, item in sorted(items, key=lambda one: one[0]):
        if isinstance(item, EncodedSound):
            part.sound(item)
        elif not isinstance(item, int):
            part.event(item, at_s)
        else:
            drawn = Picture(card.draw(round((BEGAN_S + at_s) * 1000)), at_s)
            encoded = encoder.encode(drawn, keyframe=is_keyframe(item))
            assert encoded is not None
            part.picture(encoded)
    if has_end:
        part.close()
    return part


def _heard(times_s: Sequence[float]) -> list[EncodedSound]:
    """Return sound that is loud at the beginning of each second."""
    return sounds(begin_s=times_s[0], seconds=times_s[-1] - times_s[0])


def shown_s(rows: np.ndarray[Any, Any], near_s: float) -> float:
    """Return the time that a picture shows, since 1970; `near_s` tells which day it is."""
    stamp = read_stamp(rows)
    assert stamp is not None
    near_ms = round(near_s * 1000)
    late_ms = (stamp - near_ms + STAMP_MODULUS // 2) % STAMP_MODULUS - STAMP_MODULUS // 2
    return (near_ms + late_ms) / 1000
