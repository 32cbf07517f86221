"""The test card: the time read from it is the time of capture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import av
import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.capture.card_reader import read_stamp
from tests.examples import examples

from wax.capture.source import Picture, Sound
from wax.capture.testcard import STAMP_MODULUS, TestCardAudio, TestCardVideo, crc8
from wax.config.audio import AudioSettings
from wax.config.video import VideoSettings

if TYPE_CHECKING:
    from numpy.typing import NDArray

NOW_MS = 1_795_249_152_112


class FakeClock:
    """Monotonic and wall time that move only when told to."""

    def __init__(self, now_s: float = 1000.0, wall_s: float = NOW_MS / 1000) -> None:
        self.time_s = now_s
        self.offset_s = wall_s - now_s

    def now_s(self) -> float:
        return self.time_s

    def wall_ms(self) -> int:
        return math.floor((self.time_s + self.offset_s) * 1000)

    def sleep(self, duration_s: float) -> None:
        self.time_s += duration_s


def card(width: int, height: int, wall_ms: int) -> Picture:
    """Draw one test card."""
    clock = FakeClock(wall_s=(wall_ms + 0.5) / 1000)
    source = TestCardVideo(VideoSettings(width=width, height=height), clock, sleep=clock.sleep)
    source.open()
    return source.read()


def test_crc_is_the_one_that_is_documented() -> None:
    """The check value of CRC-8 with polynomial 0x07 is 0xF4."""
    assert crc8(b"123456789") == 0xF4


@given(
    wall_ms=st.integers(1, 1 << 41).filter(lambda ms: ms % STAMP_MODULUS),
    size=st.sampled_from([(640, 480), (320, 240), (160, 120), (64, 60), (1280, 720), (354, 290)]),
)
@examples(60)
def test_every_moment_is_read_back(wall_ms: int, size: tuple[int, int]) -> None:
    """A card drawn at any Unix time and size reads back as that time modulo 2⁴⁰."""
    assert read_stamp(card(*size, wall_ms)) == wall_ms % STAMP_MODULUS


def test_cells_lie_where_the_design_says() -> None:
    """Cells are width/16 × height/15, row by row, the most significant bit first, white is 1."""
    picture = card(640, 480, NOW_MS)
    bits = ""
    for row in range(3):
        for column in range(16):
            cell = picture.i420[row * 32 : row * 32 + 32, column * 40 : column * 40 + 40]
            assert cell.min() == cell.max()
            bits += "1" if cell[0, 0] > 128 else "0"
    assert int(bits[:40], 2) == NOW_MS % STAMP_MODULUS
    assert int(bits[40:], 2) == crc8((NOW_MS % STAMP_MODULUS).to_bytes(5, "big"))


@pytest.mark.parametrize("size", [(640, 480), (320, 240), (160, 120)])
def test_a_plane_and_an_array_are_told_apart(size: tuple[int, int]) -> None:
    """A luma plane and a whole I420 array read the same without saying which it is."""
    for step in range(5):
        wall_ms = NOW_MS + step * 33_333
        picture = card(*size, wall_ms)
        assert read_stamp(picture.i420) == wall_ms % STAMP_MODULUS
        assert read_stamp(picture.i420[: picture.height].copy()) == wall_ms % STAMP_MODULUS


def test_stamp_survives_a_modem_line() -> None:
    """Scaled down by four and coded as VP8 at 20 kbit/s and 5 fps, it is still readable."""
    encoder = av.CodecContext.create("libvpx", "w")
    decoder = av.CodecContext.create("vp8", "r")
    assert isinstance(encoder, av.VideoCodecContext)
    assert isinstance(decoder, av.VideoCodecContext)
    encoder.width, encoder.height, encoder.pix_fmt = 160, 120, "yuv420p"
    encoder.framerate, encoder.bit_rate = 5, 20_000  # type: ignore[assignment]  # takes a number
    encoder.thread_count = 1
    encoder.options = {"deadline": "realtime", "cpu-used": "8", "lag-in-frames": "0"}
    read, sizes = [], []
    for index in range(20):
        luma = card(640, 480, NOW_MS + 200 * index).i420[:480]
        small = np.full((180, 160), 128, np.uint8)
        small[:120] = cv2.resize(luma, (160, 120), interpolation=cv2.INTER_AREA)
        frame = av.VideoFrame.from_ndarray(small, "yuv420p")
        frame.pts = index
        for packet in encoder.encode(frame):
            sizes.append(packet.size)
            read += [
                read_stamp(np.asarray(out.to_ndarray(), np.uint8)) for out in decoder.decode(packet)
            ]
    assert sum(sizes[1:]) * 8 / 19 * 5 < 40_000
    assert read == [(NOW_MS + 200 * index) % STAMP_MODULUS for index in range(20)]


def test_a_wrong_cell_is_noticed() -> None:
    """A stamp with one inverted cell is rejected."""
    right = card(640, 480, NOW_MS).i420
    for cell in range(48):
        i420 = right.copy()
        row, column = divmod(cell, 16)
        place = i420[row * 32 : row * 32 + 32, column * 40 : column * 40 + 40]
        place[...] = 251 - place
        assert read_stamp(Picture(i420, 0.0)) is None


@pytest.mark.parametrize("grey", [0, 16, 126, 235, 255])
def test_a_plain_picture_has_no_stamp(grey: int) -> None:
    """Black, grey and white pictures read as None, not as a time."""
    assert read_stamp(Picture(np.full((720, 640), grey, np.uint8), 0.0)) is None


def test_pictures_come_at_their_rate_with_the_moment_of_capture() -> None:
    """100 pictures at 30 fps take 3.3 s, and stamp and capture time agree."""
    clock = FakeClock()
    source = TestCardVideo(VideoSettings(width=160, height=120), clock, sleep=clock.sleep)
    source.open()
    first = source.read()
    for index in range(1, 100):
        picture = source.read()
        assert picture.captured_s - first.captured_s == pytest.approx(index / 30, abs=1e-6)
        stamp = read_stamp(picture)
        assert stamp is not None
        wall_ms = (picture.captured_s + clock.offset_s) * 1000 % STAMP_MODULUS
        assert 0 <= wall_ms - stamp < 1.001


def test_a_stall_is_not_made_up_for() -> None:
    """After a stall of 1 s the next picture is new and the rate unchanged: there is no burst."""
    clock = FakeClock()
    source = TestCardVideo(VideoSettings(width=160, height=120), clock, sleep=clock.sleep)
    source.open()
    source.read()
    clock.sleep(1.0)
    times = [source.read().captured_s for _ in range(4)]
    assert times[0] == pytest.approx(1001.0, abs=0.034)
    assert np.diff(times) == pytest.approx([1 / 30] * 3, abs=1e-6)


def test_the_lower_part_moves() -> None:
    """Texture, bars and digits change from picture to picture, so the encoder has work."""
    one, two = card(640, 480, NOW_MS), card(640, 480, NOW_MS + 33)
    changed = np.abs(one.i420[96:480].astype(int) - two.i420[96:480]) > 4
    assert changed.mean() > 0.3


def listen(clock: FakeClock, duration_s: float, source: TestCardAudio) -> list[Sound]:
    """Read sound for this long."""
    return [source.read() for _ in range(round(duration_s * 100))]


def remainder(sounds: list[Sound]) -> NDArray[np.float64]:
    """Subtract the 300 Hz tone, which must be continuous; what is left is bursts."""
    samples = np.concatenate([sound.samples for sound in sounds]) / 32767
    index = np.arange(len(samples))
    return samples - 0.05 * np.sin(2 * np.pi * 300 * index / 48000)


@given(
    now_s=st.floats(0, 1e6), wall_s=st.floats(1_700_000_000, 1_900_000_000, allow_subnormal=False)
)
@examples(25)
def test_bursts_start_at_whole_seconds(now_s: float, wall_s: float) -> None:
    """The tone never breaks, and 100 ms of 1 kHz start within 1 ms of each whole Unix second."""
    clock = FakeClock(now_s, wall_s)
    source = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
    source.open()
    sounds = listen(clock, 2.3, source)
    bursts = remainder(sounds)
    loud = np.flatnonzero(np.abs(bursts) > 0.02)
    assert np.abs(bursts).max() == pytest.approx(0.4, abs=0.01)
    starts = [loud[0], *loud[1:][np.diff(loud) > 4800]]
    for start in starts:
        at_s = sounds[0].captured_s + clock.offset_s + start / 48000
        if start > 48:
            assert abs(at_s - round(at_s)) < 0.001
    full = [start for start in starts if 48 < start < len(bursts) - 4900]
    assert full
    for start in full:
        burst = np.sin(2 * np.pi * 1000 * np.arange(4799) / 48000) * 0.4
        assert np.abs(bursts[start - 1 : start + 4798] - burst).max() < 0.001
        assert np.abs(bursts[start + 4800 : start + 9600]).max() < 0.001


def test_samples_are_counted_on_the_clock() -> None:
    """After 20 s a block's capture time is its number × 10 ms to the microsecond."""
    clock = FakeClock()
    source = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
    source.open()
    last = listen(clock, 20.0, source)[-1]
    assert last.captured_s == pytest.approx(1000 + 19.99, abs=1e-6)
    assert clock.now_s() == pytest.approx(1020, abs=1e-6)


def test_bursts_follow_a_wall_clock_that_was_set() -> None:
    """When the wall clock is set by 0.3 s, the next bursts follow it."""
    clock = FakeClock(wall_s=1_800_000_000.5)
    source = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
    source.open()
    listen(clock, 0.7, source)
    clock.offset_s += 0.3
    sounds = listen(clock, 2.0, source)
    samples = np.concatenate([sound.samples for sound in sounds])
    loud = np.flatnonzero(np.abs(samples.astype(int)) > 5000)
    starts = [int(i) for i in [loud[0], *loud[1:][np.diff(loud) > 4800]] if i > 48]
    assert starts
    for start in starts:
        at_s = sounds[0].captured_s + clock.offset_s + start / 48000
        assert abs(at_s - round(at_s)) < 0.0012


def test_sleep_of_the_machine_leaves_no_delay() -> None:
    """After 5 s without reading the next block is new, on the same sample clock."""
    clock = FakeClock()
    source = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
    source.open()
    source.read()
    clock.sleep(5.0)
    sound = source.read()
    assert clock.now_s() - sound.captured_s < 0.03
    assert (sound.captured_s - 1000) * 48000 == pytest.approx(
        round((sound.captured_s - 1000) * 48000), abs=1e-3
    )


def test_after_a_rest_the_sound_begins_now() -> None:
    """However short the rest was, nothing that was due in it is delivered."""
    clock = FakeClock()
    source = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
    source.open()
    source.read()
    clock.sleep(0.15)
    rested_s = clock.now_s()
    source.catch_up()
    assert 0.0 <= source.read().captured_s - rested_s < 0.0001


@given(before_s=st.floats(0.3, 1.6), stall_s=st.floats(0.25, 2.5))
@example(before_s=0.5, stall_s=1.015625)
@examples(50)
def test_a_burst_that_was_dropped_does_not_follow_late(before_s: float, stall_s: float) -> None:
    """Whatever is dropped, a burst starts at its whole second or not at all."""
    clock = FakeClock(wall_s=1_800_000_000.5)
    source = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
    source.open()
    listen(clock, before_s, source)
    clock.sleep(stall_s)
    sounds = listen(clock, 1.2, source)
    samples = np.concatenate([sound.samples for sound in sounds]).astype(int)
    loud = np.flatnonzero(np.abs(samples) > 5000)
    assert loud.size
    for start in (loud[0], *loud[1:][np.diff(loud) > 2400]):
        at_s = sounds[0].captured_s + clock.offset_s + start / 48000
        assert abs(at_s - round(at_s)) < 0.0012
