"""The sizes that the configuration leaves to the sources and the machine."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pytest
from structlog.testing import capture_logs

from wax.capture.own_size import OwnSize, Size
from wax.config.settings import Settings
from wax.encode.auto_size import Prepared, prepare
from wax.encode.choice import Encoders
from wax.encode.trial import Trial

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.video import VideoSettings

LADDER = [{"width": 320, "height": 180, "fps": 30.0, "bitrate_bps": 300_000}]


class Machine:
    """A machine that takes so long for an HD picture, and whose hardware encodes these."""

    def __init__(self, ms: float, hardware: Sequence[str] = ()) -> None:
        self.ms = ms
        self.hardware = hardware
        self.tried: list[str] = []
        self.asked = 0

    def choose(self, cameras: Sequence[VideoSettings]) -> list[Encoders]:
        trial = Trial("h264_qsv", ms=dict.fromkeys(self.hardware, 2.0))
        return [Encoders(one, [trial] if self.hardware else []) for one in cameras]

    def encode_ms(self, rendition: Any, _codec: str) -> float:
        self.tried.append(rendition.size)
        return self.ms

    def prepare(self, *, shape: tuple[int, int] = (16, 9), **tables: Any) -> Prepared:
        def own_size(_video: Any, _driver: Any, most: Size, **_: Any) -> OwnSize:
            self.asked += 1
            return OwnSize(Size(most.height * shape[0] // shape[1] // 2 * 2, most.height), "it is")

        return prepare(
            Settings.model_validate(tables),
            None,
            choose=self.choose,
            encode_ms=self.encode_ms,
            own_size=own_size,
        )


def sizes(video: VideoSettings) -> list[str]:
    return [f"{video.width}x{video.height}", *dict.fromkeys(one.size for one in video.renditions)]


def test_a_machine_that_is_fast_enough_sends_hd() -> None:
    """The source's best size and its ladder are used, and the log says why in one line."""
    fast = Machine(12.0)
    prepared = fast.prepare()
    assert sizes(prepared.settings.video) == [
        *("1280x720", "1280x720", "960x540", "640x360", "320x180", "160x90")
    ]
    assert fast.tried == ["1280x720"]
    with capture_logs() as logs:
        prepared.log()
    (line,) = logs
    assert (line["log_level"], line["video"]) == (
        "info",
        "1280x720: it is; the processor encodes 1280x720 in 12.0 ms, and 20 ms is the most",
    )
    assert "960x540 at 1000 kbit/s" in line["renditions"]


def test_a_machine_that_is_too_slow_sends_vga_and_says_so() -> None:
    """The sizes are what they were before, and the log warns."""
    prepared = Machine(80.0).prepare(shape=(4, 3))
    assert sizes(prepared.settings.video) == ["640x480", "640x480", "320x240", "160x120"]
    assert prepared.settings.video.renditions == Settings().video.renditions
    with capture_logs() as logs:
        prepared.log()
    assert (logs[0]["log_level"], "too slow for more: the proc" in logs[0]["video"]) == (
        "warning",
        True,
    )


def test_a_slow_machine_asks_a_stream_for_its_size_once() -> None:
    """The smaller size is made from the one that is known, in its proportions."""
    slow = Machine(80.0)
    prepared = slow.prepare(video={"source": "rtsp://camera.example/"})
    assert sizes(prepared.settings.video)[:2] == ["640x360", "640x360"]
    assert slow.asked == 1


def test_hardware_makes_a_slow_processor_fast_enough() -> None:
    """Where hardware encodes the best size, the processor is not tried."""
    slow = Machine(80.0, ["1280x720 at 2500 kbit/s"])
    assert sizes(slow.prepare(video={"codec": "h264"}).settings.video)[0] == "1280x720"
    assert slow.tried == []


@pytest.mark.parametrize(
    ("tables", "size"),
    [
        ({"video": {"width": 1920, "height": 1080}}, "1920x1080"),
        ({"video": {"renditions": LADDER}}, "320x180"),
        ({"video": {"renditions": LADDER, "width": 640, "height": 360}}, "640x360"),
        ({"video": {"source": "none"}}, "852x480"),
        ({"sync": {"policy": "thesis"}}, "640x480"),
    ],
)
def test_what_is_configured_is_not_tried(tables: dict[str, Any], size: str) -> None:
    """An explicit size, or that of an explicit ladder, wins, and sources hear it."""
    slow = Machine(80.0)
    video = slow.prepare(shape=(71, 40), **tables).settings.video
    assert (f"{video.width}x{video.height}", slow.tried) == (size, [])
    assert not video.has_auto_size


def test_rooms_get_a_step_that_is_paid_for_by_the_byte() -> None:
    """Viewers have HD; rooms get at most 1 Mbit/s of the automatic ladder, and all of your own."""
    rooms: dict[str, Any] = {"publish": [{"whip": "https://room.example/"}]}
    prepared = Machine(12.0).prepare(**rooms)
    assert sizes(prepared.settings.video)[0] == "1280x720"
    assert prepared.rooms_bps == 1_000_000
    own = Machine(12.0).prepare(**rooms, video={"renditions": LADDER})
    assert own.rooms_bps == math.inf


def test_a_camera_on_its_side_has_a_ladder_that_stands() -> None:
    """The source is asked for its own size, and the renditions are turned."""
    video = Machine(12.0).prepare(video={"rotate": 90}).settings.video
    assert sizes(video)[:3] == ["1280x720", "720x1280", "540x960"]


def test_a_camera_beside_the_view_is_small_and_of_its_own_shape() -> None:
    """It is at most VGA whatever the machine can do, with its own ladder of three."""
    beside = {"name": "event", "source": "camera:1"}
    prepared = Machine(12.0).prepare(camera=[beside])
    assert sizes(prepared.settings.camera[0]) == ["852x480", "852x480", "320x180", "160x90"]
    with capture_logs() as logs:
        prepared.log()
    assert logs[0]["cameras"] == {"event": "852x480: it is"}
