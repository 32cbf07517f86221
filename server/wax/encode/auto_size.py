"""Decides the sizes that the configuration leaves to the sources and to this machine."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Final, TypeVar

import structlog

from wax.capture.file.address import is_network
from wax.capture.own_size import HD, VGA, OwnSize, Size, fitted, has_topic, own_size
from wax.config.camera import CameraSettings
from wax.config.ladder import BESIDE, DRIVING
from wax.config.video import VideoSettings, ladder_settings, upright_size
from wax.encode.choice import Encoders, choose
from wax.encode.speed import encode_ms, most_ms

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.config.settings import Settings
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

VideoT = TypeVar("VideoT", bound=VideoSettings)

_ROOMS_BPS: Final = 1_000_000
"""Media servers are paid by the byte: rooms get no more of an automatic ladder, which is sharper
at that rate than 640×480."""
_YOURS: Final = "as configured"


@dataclass(frozen=True, slots=True)
class Prepared:
    """The settings with every size decided, the encoders of all cameras, and why.

    `encoders` has the driving view's, then each camera's; it is empty under the thesis's policy.
    `chosen` says of the driving view, then of each camera, what was chosen and why. `is_slow` is
    whether this machine is too slow for what the driving view's source has.
    """

    settings: Settings
    encoders: list[Encoders]
    chosen: list[str]
    is_slow: bool = False
    rooms_bps: float = math.inf
    """The most for one rendition in the rooms of publish."""

    @property
    def driving_view(self) -> tuple[VideoSettings, Encoders]:
        """Its settings and encoders."""
        video = self.settings.video
        return video, self.encoders[0] if self.encoders else Encoders(video)

    def log(self) -> None:
        """Log in one line what was chosen and why; a warning if this machine is too slow."""
        names = [one.name for one in self.settings.camera]
        beside = {"cameras": dict(zip(names, self.chosen[1:], strict=True))} if names else {}
        tell = _LOG.warning if self.is_slow else _LOG.info
        tell(
            "the size of the picture",
            video=self.chosen[0],
            **beside,
            renditions=", ".join(one.name for one in self.settings.video.renditions),
        )


def prepare(
    settings: Settings,
    driver: Driver | None,
    *,
    choose: Callable[..., list[Encoders]] = choose,
    encode_ms: Callable[..., float] = encode_ms,
    own_size: Callable[..., OwnSize] = own_size,
) -> Prepared:
    """Decide all sizes, and choose the encoders. Sizes that are configured stay as they are."""
    if settings.sync.policy == "thesis":
        size = Size(settings.video.width, settings.video.height)
        own = OwnSize(size, "the thesis's policy has its own")
        video, _ = _sized(settings.video, lambda: own)
        settings = settings.model_copy(update={"video": video})
        return Prepared(settings, [], [f"{own.size}: {own.why}"])
    video, cameras = settings.video, settings.camera
    taken = [one.source for one in cameras]
    with ThreadPoolExecutor() as pool:  # an address that does not answer takes seconds
        looks = [partial(own_size, one, driver, VGA) for one in cameras]
        beside = list(pool.map(_sized, cameras, looks))
    others, told = [one for one, _ in beside], [why for _, why in beside]

    is_auto = video.has_auto_size and video.has_auto_ladder
    rooms_bps = _ROOMS_BPS if is_auto else math.inf

    def prepared(
        most: Size, why: str = "", *, is_slow: bool = False, known: Size | None = None
    ) -> Prepared:
        def look() -> OwnSize:
            if known is not None:
                return OwnSize(fitted(*known, most), why)
            return own_size(video, driver, most, taken=taken)

        view, chosen = _sized(video, look, why)
        found = settings.model_copy(update={"video": view, "camera": others})
        return Prepared(found, choose([view, *others]), [chosen, *told], is_slow, rooms_bps)

    is_seen = video.source != "none"
    best = prepared(HD) if is_seen else prepared(VGA, "there is no picture")
    top = best.settings.video.renditions[0]
    is_large = top.width * top.height > VGA.width * VGA.height
    if not (is_seen and is_auto and is_large) or best.encoders[0].hardware_for(top) is not None:
        return best
    took_ms, may_ms = encode_ms(top, video.codec), most_ms(top.fps)
    measured = (
        f"the processor encodes {top.size} in {took_ms:.1f} ms, and {may_ms:.0f} ms is the most"
    )
    if took_ms > may_ms:
        # Asked once: many cameras serve one client, and a topic's first picture takes seconds.
        view = best.settings.video
        is_asked = is_network(video.source) or has_topic(video, driver)
        known = Size(view.width, view.height) if is_asked else None
        why = f"this machine is too slow for more: {measured}"
        return prepared(VGA, why, is_slow=True, known=known)
    return replace(best, chosen=[f"{best.chosen[0]}; {measured}", *told])


def _sized(video: VideoT, look: Callable[[], OwnSize], why: str = "") -> tuple[VideoT, str]:
    """Return the settings with a size, and what was chosen and why, if not as `look` says."""
    if not video.has_auto_size:
        return video, f"{_size(video)}: {_YOURS}"
    if video.has_auto_ladder:
        own = look()
    else:
        best = video.renditions[0]
        size = Size(*upright_size(best.width, best.height, video.rotate))
        own = OwnSize(size, "the first rendition has it")
    width, height = own.size
    update: dict[str, object] = {"width": width, "height": height}
    if video.has_auto_ladder:
        upright = upright_size(width, height, video.rotate)
        steps = BESIDE if isinstance(video, CameraSettings) else DRIVING
        update["renditions"] = ladder_settings(*upright, video.fps, steps)
    return video.model_copy(update=update), f"{own.size}: {why or own.why}"


def _size(video: VideoSettings) -> str:
    return f"{video.width}x{video.height}"
