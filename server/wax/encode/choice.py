"""Chooses each rendition's encoder: hardware that has passed its trial, else the processor."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

import structlog

from wax.encode.hardware import HARDWARE, Hardware, HardwareEncoder
from wax.encode.one_thread import OneThread
from wax.encode.trials import try_all
from wax.encode.video_encoder import VideoEncoder
from wax.errors import reason_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.capture.source import Picture
    from wax.config.video import RenditionSettings, VideoSettings
    from wax.encode.encoded import EncodedPicture
    from wax.encode.trial import Trial
    from wax.encode.video_encoder import PictureEncoder

_LOG = structlog.get_logger(__name__)

_HANGS_S: Final = 1.0
"""An encoder that takes longer for a picture is hung."""
SOFTWARE: Final = {"vp8": "libvpx", "h264": "libx264"}


class Encoders:
    """Builds the encoders of one camera, each in its rendition's thread.

    `trials` say what works on this machine. If a rendition's hardware fails later, the processor
    encodes it, beginning with that very picture, until the server is restarted.
    """

    def __init__(self, settings: VideoSettings, trials: Sequence[Trial] = ()) -> None:
        self._codec = settings.codec
        self._wanted = settings.encoder
        self._trials = trials
        self._best = best(trials, settings.renditions)
        self._sizes = {
            (one.width, one.height): one.fps
            for one in reversed(settings.renditions)
            if self._best is not None and one.name in self._best.ms
        }
        self._lock = threading.Lock()
        self._failed: dict[str, str] = {}

    def make(self, rendition: RenditionSettings) -> PictureEncoder:
        """Build an encoder; raises what the processor's encoder raises."""

        def by_processor() -> PictureEncoder:
            return VideoEncoder(codec=self._codec, rendition=rendition)

        hardware = self.hardware_for(rendition)
        if hardware is None:
            return by_processor()
        return _WithFallback(
            lambda: HardwareEncoder(hardware, rendition),
            by_processor,
            lambda why: self._record_failure(rendition, why),
        )

    def name_of(self, rendition: RenditionSettings) -> str:
        """Return FFmpeg's name of this rendition's encoder."""
        hardware = self.hardware_for(rendition)
        return SOFTWARE[self._codec] if hardware is None else hardware.name

    @property
    def problem(self) -> str | None:
        """A sentence if the configured encoder does not work or has failed, else None."""
        if self._failed:
            size, why = next(iter(self._failed.items()))
            return f"{self._wanted_name()} has failed at {size} ({why}); the processor encodes it."
        if self._wanted in ("auto", "software") or self._best is not None:
            return None
        why = next((one.problem for one in self._trials if one.problem), "it was not tried")
        return f"{self._wanted} does not work here ({why}); the processor encodes."

    @property
    def refused(self) -> dict[str, str | dict[str, str]]:
        """Why each hardware encoder that was tried is not used."""
        return {one.encoder: one.problem or one.refused for one in self._trials}

    def status(self) -> dict[str, object]:
        """Return the chosen encoder and the reasons, for `GET /api/status`."""
        return {
            "chosen": SOFTWARE[self._codec] if self._best is None else self._best.encoder,
            "ms": {} if self._best is None else self._best.ms,
            "refused": self.refused,
            "failed": dict(self._failed),
        }

    def hardware_for(self, rendition: RenditionSettings) -> Hardware | None:
        """Return the hardware that encodes this rendition, as far as the trials tell."""
        if self._best is None or rendition.name in self._failed:
            return None
        fps = self._sizes.get((rendition.width, rendition.height))
        if fps is None or rendition.fps > fps:
            return None
        return known(self._best.encoder)

    def _wanted_name(self) -> str:
        return self._wanted if self._best is None else self._best.encoder

    def _record_failure(self, rendition: RenditionSettings, why: str) -> None:
        with self._lock:
            self._failed[rendition.name] = why
        _LOG.warning(
            "a hardware encoder has failed; the processor encodes instead",
            encoder=self._wanted_name(),
            rendition=rendition.name,
            why=why,
        )


class _WithFallback:
    """Uses hardware until it fails or hangs, then the processor, which starts with a keyframe."""

    def __init__(
        self,
        make_hardware: Callable[[], PictureEncoder],
        make_software: Callable[[], PictureEncoder],
        note: Callable[[str], None],
    ) -> None:
        self._make_hardware = make_hardware
        self._make_software = make_software
        self._note = note
        self._hardware: PictureEncoder | None = None
        self._software: PictureEncoder | None = None
        self._thread = OneThread("hardware encoder")

    def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
        if self._software is None:
            try:
                return self._thread.call(lambda: self._encode(picture, keyframe), _HANGS_S)
            except Exception as error:  # any failure of a system driver, through FFmpeg and PyAV
                self._thread.end()
                self._note(reason_of(error))
                self._software = self._make_software()
        return self._software.encode(picture, keyframe=keyframe)

    def _encode(self, picture: Picture, keyframe: bool) -> EncodedPicture | None:
        if self._hardware is None:
            self._hardware = self._make_hardware()
        return self._hardware.encode(picture, keyframe=keyframe)

    def __del__(self) -> None:
        self._thread.end()


def choose(
    cameras: Sequence[VideoSettings],
    try_all: Callable[[Sequence[Hardware], Sequence[RenditionSettings]], list[Trial]] = try_all,
) -> list[Encoders]:
    """Try the configured encoders with all cameras at once, choose for each, and log it."""
    wanted = [one for one in cameras if one.codec == "h264" and one.encoder != "software"]
    names = {one.encoder for one in wanted}
    tried = [one for one in HARDWARE if "auto" in names or one.name in names]
    renditions = {r.name: r for one in wanted for r in one.renditions}
    trials = (
        {one.encoder: one for one in try_all(tried, list(renditions.values()))} if tried else {}
    )
    found = [Encoders(one, _of(one, trials)) for one in cameras]
    for encoders in found:
        if encoders.problem is not None:
            _LOG.warning("a hardware encoder does not work", problem=encoders.problem)
    if wanted:
        _LOG.info("encoders were tried", **{name: told(one) for name, one in trials.items()})
    return found


def _of(settings: VideoSettings, trials: dict[str, Trial]) -> list[Trial]:
    if settings.codec != "h264" or settings.encoder == "software":
        return []
    return [one for name, one in trials.items() if settings.encoder in ("auto", name)]


def best(trials: Sequence[Trial], renditions: Sequence[RenditionSettings]) -> Trial | None:
    """Return the first trial with the most renditions among those that encode the best one."""
    fit = [one for one in trials if renditions[0].name in one.ms]
    return max(fit, key=lambda one: sum(r.name in one.ms for r in renditions), default=None)


def known(name: str) -> Hardware:
    """Return the hardware encoder of this name."""
    return next(one for one in HARDWARE if one.name == name)


def told(trial: Trial) -> str:
    """Return a trial's result in a few words."""
    if trial.problem is not None:
        return f"no: {trial.problem}"
    times = ", ".join(f"{name} in {ms:.1f} ms" for name, ms in trial.ms.items())
    return f"works: {times}" + (f"; not {', '.join(trial.refused)}" if trial.refused else "")
