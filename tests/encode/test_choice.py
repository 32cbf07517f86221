"""The choice of encoders: hardware that passed, then the processor once it fails."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

import pytest
from structlog.testing import capture_logs
from tests.encode.encoders import GOOD, LARGE, SMALL, picture

from wax.config import settings as config
from wax.config.video import RenditionSettings, VideoSettings
from wax.encode import choice
from wax.encode.choice import Encoders, choose
from wax.encode.hardware import HardwareEncoder, HardwareError
from wax.encode.list_encoders import list_encoders
from wax.encode.trial import Trial
from wax.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.capture.source import Picture
    from wax.encode.encoded import EncodedPicture
    from wax.encode.hardware import Hardware

LADDER = [LARGE, SMALL]


def settings(**keys: Any) -> VideoSettings:
    return VideoSettings.model_validate({"codec": "h264", "renditions": LADDER, **keys})


def passed(name: str, *renditions: RenditionSettings, problem: str | None = None) -> Trial:
    return Trial(name, ms={one.name: 2.0 for one in renditions}, problem=problem)


class Tried:
    """Records what it was asked to try."""

    def __init__(self, *trials: Trial) -> None:
        self.trials = trials
        self.names: list[str] = []

    def __call__(
        self, candidates: Sequence[Hardware], renditions: Sequence[RenditionSettings]
    ) -> list[Trial]:
        self.names = [one.name for one in candidates]
        found = {one.encoder: one for one in self.trials}
        return [found.get(name, Trial(name, problem="it is not here")) for name in self.names]


@pytest.fixture
def x264(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the hardware by a real software encoder."""
    monkeypatch.setattr(choice, "known", lambda _: GOOD)


def test_what_passed_encodes(x264: None) -> None:
    """Among the passed encoders the first with the most renditions is chosen for these."""
    tried = Tried(passed("h264_qsv", LARGE), passed("h264_amf", LARGE, SMALL))
    (found,) = choose([settings()], tried)
    assert tried.names == ["h264_nvenc", "h264_qsv", "h264_amf", "h264_v4l2m2m"]
    assert found.status()["chosen"] == "h264_amf"
    assert found.problem is None
    encoded = found.make(LARGE).encode(picture(0, (320, 240)), keyframe=True)
    assert encoded is not None
    assert encoded.keyframe


def test_without_any_the_processor_encodes() -> None:
    """If none passed, "auto" is no problem, and the status has the reasons."""
    with capture_logs() as logs:
        (found,) = choose([settings()], Tried())
    status: dict[str, Any] = found.status()
    assert status["chosen"] == "libx264"
    assert status["refused"]["h264_nvenc"] == "it is not here"
    assert found.problem is None
    assert [one["h264_nvenc"] for one in logs] == ["no: it is not here"]
    assert found.make(SMALL).encode(picture(0), keyframe=True) is not None


@pytest.mark.parametrize(
    ("keys", "names"),
    [
        ({"codec": "vp8"}, []),
        ({"encoder": "software"}, []),
        ({"encoder": "h264_v4l2m2m"}, ["h264_v4l2m2m"]),
    ],
)
def test_only_what_may_be_used_is_tried(keys: dict[str, Any], names: list[str]) -> None:
    """VP8 and "software" try nothing, a name tries only that encoder."""
    tried = Tried()
    (found,) = choose([settings(**keys)], tried)
    assert tried.names == names
    assert (found.problem is None) == (not names)
    if names:
        assert found.problem == (
            "h264_v4l2m2m does not work here (it is not here); the processor encodes."
        )


def test_one_that_fails_at_the_best_size_is_not_taken() -> None:
    """An encoder that fails at the largest picture is not chosen: that is what hardware is for."""
    (found,) = choose([settings()], Tried(passed("h264_qsv", SMALL)))
    assert found.status()["chosen"] == "libx264"


def test_each_rendition_has_its_own(x264: None) -> None:
    """The processor encodes sizes that failed; an added rendition uses its size's encoder."""
    (found,) = choose([settings()], Tried(passed("h264_nvenc", LARGE)))
    own = RenditionSettings(width=320, height=240, fps=25, bitrate_bps=300_000)
    faster = RenditionSettings(width=320, height=240, fps=60, bitrate_bps=300_000)
    wanted = [(LARGE, "libx264"), (SMALL, "libx264"), (own, "libx264"), (faster, "libx264")]
    assert [(one, found.name_of(one)) for one, _ in wanted] == wanted
    kinds = [type(found.make(one)).__name__ for one, _ in wanted]
    assert kinds == ["_WithFallback", "VideoEncoder", "_WithFallback", "VideoEncoder"]


class Flaky:
    """Hardware that fails at its third picture as instructed."""

    def __init__(self, how: str, inner: Any) -> None:
        self.how, self.inner, self.count = how, inner, 0
        self.released = threading.Event()

    def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
        self.count += 1
        if self.count == 3 and self.how == "raises":
            raise HardwareError("the device is gone")
        if self.count == 3:
            self.released.wait(10)
        found: EncodedPicture | None = self.inner.encode(picture, keyframe=keyframe)
        return found


@pytest.mark.parametrize(
    ("how", "why"), [("raises", "the device is gone"), ("hangs", "it does not answer")]
)
def test_no_picture_is_lost_when_it_fails(
    monkeypatch: pytest.MonkeyPatch, x264: None, how: str, why: str
) -> None:
    """The picture at which hardware fails or hangs becomes the processor's first keyframe."""
    real = HardwareEncoder
    made: list[Flaky] = []

    def flaky(hardware: Hardware, rendition: RenditionSettings) -> Flaky:
        made.append(Flaky(how, real(hardware, rendition)))
        return made[-1]

    monkeypatch.setattr(choice, "HardwareEncoder", flaky)
    (found,) = choose([settings()], Tried(passed("h264_nvenc", LARGE, SMALL)))
    encoder = found.make(SMALL)
    with capture_logs() as logs:
        encoded = [encoder.encode(picture(number), keyframe=False) for number in range(2)]
        if how == "hangs":
            monkeypatch.setattr(choice, "_HANGS_S", 0.05)  # the next one does
        encoded += [encoder.encode(picture(number), keyframe=False) for number in range(2, 6)]
    made[0].released.set()
    assert [one is not None and one.keyframe for one in encoded] == [True, False, True] + [
        False
    ] * 3
    assert [(one["log_level"], one["why"]) for one in logs] == [("warning", why)]
    status: dict[str, Any] = found.status()
    assert status["failed"] == {SMALL.name: why}
    assert found.problem is not None
    # After a pause this rendition's next encoder does not try the hardware again.
    assert type(found.make(SMALL)).__name__ == "VideoEncoder"
    assert type(found.make(LARGE)).__name__ == "_WithFallback"


def test_one_that_does_not_open_is_a_failure_like_another(
    monkeypatch: pytest.MonkeyPatch, x264: None
) -> None:
    """Hardware that does not open, as with too many sessions, falls back to the processor."""

    def none(hardware: Hardware, rendition: RenditionSettings) -> None:
        raise HardwareError("OpenEncodeSessionEx failed: out of memory")

    monkeypatch.setattr(choice, "HardwareEncoder", none)
    (found,) = choose([settings()], Tried(passed("h264_nvenc", LARGE)))
    encoded = found.make(LARGE).encode(picture(0, (320, 240)), keyframe=False)
    assert encoded is not None
    assert encoded.keyframe


def test_its_thread_ends_with_it(x264: None) -> None:
    """An encoder that is no longer used leaves no thread."""
    (found,) = choose([settings()], Tried(passed("h264_nvenc", LARGE)))
    encoder = found.make(LARGE)
    assert encoder.encode(picture(0, (320, 240)), keyframe=False) is not None
    (thread,) = [one for one in threading.enumerate() if one.name == "hardware encoder"]
    del encoder
    thread.join(timeout=5)
    assert not thread.is_alive()


def test_several_cameras_are_tried_together() -> None:
    """All cameras share the hardware, so one trial encodes all their renditions."""
    asked: list[list[str]] = []

    def tried(
        candidates: Sequence[Hardware], renditions: Sequence[RenditionSettings]
    ) -> list[Trial]:
        asked.append([one.name for one in renditions])
        return [passed(one.name, *renditions) for one in candidates]

    found = choose([settings(), settings(renditions=[SMALL]), settings(codec="vp8")], tried)
    assert asked == [[LARGE.name, SMALL.name]]
    assert [one.status()["chosen"] for one in found] == ["h264_nvenc", "h264_nvenc", "libvpx"]


def test_hardware_for_vp8_is_a_contradiction() -> None:
    """Hardware for VP8 is refused with what to write."""
    with pytest.raises(ConfigError, match=r'encoder h264_qsv makes H\.264; set codec = "h264"'):
        config.parse({"video": {"encoder": "h264_qsv"}}, "robot.toml")


def test_they_are_listed() -> None:
    """`wax devices` lists each encoder with its time or its reason."""
    lines = list_encoders(lambda _, renditions: [passed("h264_nvenc", *renditions)])
    assert lines[1] == (
        "  h264_nvenc    works: 1280x720 at 2500 kbit/s in 2.0 ms, 640x480 at 1000 kbit/s in 2.0 ms"
    )
    refused = Encoders(settings(), [Trial("h264_qsv", problem="it is not here")])
    assert refused.status()["refused"] == {"h264_qsv": "it is not here"}
