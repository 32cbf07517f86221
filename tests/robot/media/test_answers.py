"""The media process's answers and how the server handles them, without a process."""

from __future__ import annotations

import math
import os
import threading
import time
from multiprocessing.connection import Connection, Pipe
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.until import until

from wax.capture.source import Picture, Sound
from wax.clock import SystemClock
from wax.errors import ProtocolError, SourceError
from wax.robot.media.link import STARTING, MediaProcessLink, SenseError
from wax.robot.media.messages import NEXT, Answer, decode, encode
from wax.robot.media.outlets import CameraOutlet, MicrophoneOutlet, checked_picture, checked_sound
from wax.robot.media.picture_memory import PictureMemory, make_memory
from wax.robot.media.senses import RemoteCamera, RemoteMicrophone
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

SILENT = Sentence("camera.silent")
GONE = Sentence("media.hangs")


def nothing() -> None: ...


@pytest.fixture
def link() -> MediaProcessLink:
    return MediaProcessLink(SILENT)


@pytest.fixture
def far(link: MediaProcessLink) -> Iterator[Connection]:
    """Return the process's end of the link."""
    ours, theirs = Pipe()
    link.attach(ours, None)
    yield theirs
    theirs.close()
    link.detach(GONE)
    ours.close()


def answers(far: Connection, *said: bytes) -> threading.Thread:
    """Answer the next requests in turn."""

    def run() -> None:
        for one in said:
            far.recv_bytes()
            far.send_bytes(one)

    thread = threading.Thread(target=run)
    thread.start()
    return thread


@given(
    st.builds(
        Answer,
        captured_s=st.floats(allow_nan=False, allow_infinity=False),
        width=st.integers(0, 100).map(lambda half: half * 2),
        height=st.integers(0, 100).map(lambda half: half * 2),
        channels=st.integers(1, 2),
        problem=st.none() | st.just(SILENT),
    ),
    st.binary(max_size=64),
)
def test_an_answer_comes_as_it_was_sent(answer: Answer, payload: bytes) -> None:
    """Its payload may contain newlines."""
    assert decode(encode(answer, payload)) == (answer, payload)


@given(st.binary(max_size=200))
def test_any_bytes_are_a_valid_answer_or_refused(data: bytes) -> None:
    """No bytes give an answer out of range."""
    try:
        answer, _ = decode(data)
    except ProtocolError:
        return
    assert answer.width % 2 == answer.height % 2 == 0
    assert math.isfinite(answer.captured_s)


def test_an_answer_is_waited_for(link: MediaProcessLink, far: Connection) -> None:
    """A problem in an answer is raised."""
    thread = answers(far, encode(Answer(captured_s=1.5), b"x"), encode(Answer(problem=GONE)))
    assert link.ask(NEXT, 2.0) == (Answer(captured_s=1.5), b"x")
    with pytest.raises(SenseError) as failed:
        link.ask(NEXT, 2.0)
    assert failed.value.sentence == GONE
    thread.join()


def test_without_a_process_the_problem_says_why(link: MediaProcessLink) -> None:
    """Before the first, it is starting."""
    for problem in (STARTING, GONE):
        with pytest.raises(SenseError) as failed:
            link.ask(NEXT, 0.01)
        assert failed.value.sentence == problem
        link.detach(GONE)


def test_a_request_is_not_sent_twice(link: MediaProcessLink, far: Connection) -> None:
    """A late answer counts for its own request only."""
    with pytest.raises(SenseError):
        link.ask(NEXT, 0.01)
    assert far.recv_bytes() == NEXT
    far.send_bytes(encode(Answer(captured_s=1.0)))
    assert link.ask(NEXT, 2.0)[0].captured_s == 1.0
    with pytest.raises(SenseError):
        link.ask(NEXT, 0.01)
    far.recv_bytes()
    far.send_bytes(encode(Answer(captured_s=2.0)))
    thread = answers(far, encode(Answer(captured_s=3.0)))
    assert link.ask(b"other", 2.0)[0].captured_s == 3.0
    thread.join()


def test_a_process_that_has_answered_is_silent(link: MediaProcessLink, far: Connection) -> None:
    """It no longer counts as starting."""
    thread = answers(far, encode(Answer()))
    link.ask(NEXT, 2.0)
    thread.join()
    with pytest.raises(SenseError) as failed:
        link.ask(NEXT, 0.01)
    assert failed.value.sentence == SILENT


@pytest.mark.parametrize("end", ["close", "garbage"])
def test_the_reason_for_its_end_is_awaited(
    link: MediaProcessLink, far: Connection, end: str
) -> None:
    """The supervisor reports it a moment later."""
    far.close() if end == "close" else far.send_bytes(b"{")
    timer = threading.Timer(0.05, link.detach, (GONE,))
    timer.start()
    with pytest.raises(SenseError) as failed:
        link.ask(NEXT, 2.0)
    assert failed.value.sentence == GONE
    timer.join()


class _EndsMeanwhile:
    """A connection whose process is reported as ended while its last message is being read."""

    def __init__(self, link: MediaProcessLink) -> None:
        self._link = link

    def send_bytes(self, _question: bytes) -> None: ...

    def poll(self, _within_s: float) -> bool:
        return True

    def recv_bytes(self, _most: int) -> bytes:
        self._link.detach(GONE)
        return b"{"


def test_a_late_answer_does_not_hide_why_the_process_ended(link: MediaProcessLink) -> None:
    """The reason stands although the message was read after it."""
    link.attach(_EndsMeanwhile(link), None)  # type: ignore[arg-type]
    with pytest.raises(SenseError) as failed:
        link.ask(NEXT, 2.0)
    assert failed.value.sentence == GONE


def test_a_new_process_gets_new_requests(link: MediaProcessLink, far: Connection) -> None:
    """A request that the last process did not answer is dropped."""
    with pytest.raises(SenseError):
        link.ask(NEXT, 0.01)
    ours, theirs = Pipe()
    link.attach(ours, None)
    thread = answers(theirs, encode(Answer(captured_s=7.0)))
    assert link.ask(NEXT, 2.0)[0].captured_s == 7.0
    thread.join()
    theirs.close()
    link.detach(GONE)
    ours.close()


def test_a_request_times_out(link: MediaProcessLink, far: Connection) -> None:
    """No answer in time is an error."""
    start_s = time.monotonic()
    with pytest.raises(SenseError):
        link.ask(NEXT, 0.2)
    assert time.monotonic() - start_s < 1.0


def test_a_picture_in_memory_is_copied_out() -> None:
    """A later write does not change the copy."""
    descriptor = make_memory()
    near, far = PictureMemory(descriptor), PictureMemory(descriptor)
    first = np.arange(32 * 48, dtype=np.uint8).reshape(48, 32)
    far.write(first)
    picture = near.read(32, 32, 5.0, 0.1)
    far.write(np.zeros((48, 32), np.uint8))
    assert np.array_equal(picture.i420, first)
    assert (picture.width, picture.height, picture.captured_s) == (32, 32, 5.0)
    assert picture.within_s == 0.1
    os.close(descriptor)


def test_an_answer_without_a_picture_is_no_picture(link: MediaProcessLink, far: Connection) -> None:
    """An empty answer means that camera or microphone delivers nothing."""
    thread = answers(far, encode(Answer()), encode(Answer()))
    with pytest.raises(SourceError, match="camera delivers nothing"):
        RemoteCamera(link, nothing).read()
    with pytest.raises(SourceError, match="microphone delivers nothing"):
        RemoteMicrophone(link, nothing).read()
    thread.join()


class Sleeper:
    """A camera that may rest, with the number of each picture as its time."""

    rest_s = 0.0

    def __init__(self) -> None:
        self.frames = threading.Semaphore(0)
        self.made = 0

    def open(self) -> None: ...

    def read(self) -> Picture:
        self.frames.acquire()
        self.made += 1
        return Picture(yuv(3, 2), float(self.made))

    def close(self) -> None: ...


class Tireless(Sleeper):
    """A camera that may not rest."""

    rest_s = None  # type: ignore[assignment]


@pytest.fixture
def sleeper() -> Sleeper:
    return Sleeper()


@pytest.fixture
def outlet(link: MediaProcessLink, sleeper: Sleeper) -> Iterator[CameraOutlet]:
    ours, theirs = Pipe()
    descriptor = make_memory()
    link.attach(ours, descriptor)
    memory = PictureMemory(descriptor)
    outlet = CameraOutlet(lambda: sleeper, theirs, memory, name="camera", clock=SystemClock())
    outlet.start()
    yield outlet
    outlet.request_stop()
    sleeper.frames.release()
    outlet.stop()
    link.detach(GONE)
    ours.close()
    outlet._answers._thread.join()
    theirs.close()
    os.close(descriptor)


def test_pictures_are_taken_while_the_last_one_is_used(
    link: MediaProcessLink, outlet: CameraOutlet, sleeper: Sleeper
) -> None:
    """Who asks for one picture after another does not wait for a camera that may rest."""
    for number in range(1, 6):
        sleeper.frames.release()
        until(lambda: outlet._slot.count > outlet._seen)
        assert RemoteCamera(link, nothing).read().captured_s == number


def test_a_camera_rests_while_nobody_asks(
    link: MediaProcessLink, outlet: CameraOutlet, sleeper: Sleeper
) -> None:
    """From its opening on, it takes two pictures unasked, and who then asks gets a new one."""
    sleeper.frames.release(100)
    for asked in range(1, 4):
        until(lambda: sleeper.made and not outlet._slot.needed.is_set())
        until(lambda: outlet._slot.count == sleeper.made)
        made = sleeper.made
        assert made <= 3 * asked
        assert RemoteCamera(link, nothing).read().captured_s > made


@pytest.mark.parametrize("sleeper", [Tireless()])
def test_a_camera_that_may_not_rest_is_read_without_being_asked(
    outlet: CameraOutlet, sleeper: Sleeper
) -> None:
    """It may queue what is not read."""
    sleeper.frames.release(5)
    until(lambda: outlet._slot.count == 5)


class Ear:
    """A microphone that may rest, with the number of each block as its time."""

    rest_s = 0.0

    def __init__(self) -> None:
        self.blocks = threading.Semaphore(0)
        self.made = self.caught_up = 0

    def open(self) -> None: ...

    def read(self) -> Sound:
        self.blocks.acquire()
        self.made += 1
        return Sound(np.zeros(480, np.int16), float(self.made))

    def catch_up(self) -> None:
        self.caught_up += 1

    def close(self) -> None: ...


def test_a_microphone_rests_while_nobody_asks(link: MediaProcessLink) -> None:
    """It stops after a whole queue, which whoever has rested drops."""
    ear, (ours, theirs) = Ear(), Pipe()
    link.attach(ours, None)
    outlet = MicrophoneOutlet(lambda: ear, theirs, clock=SystemClock())
    outlet.start()
    microphone = RemoteMicrophone(link, nothing)
    ear.blocks.release(30)
    until(lambda: not outlet._needed.is_set())
    assert (ear.made, ear.caught_up) == (20, 0)
    microphone.catch_up()
    assert [microphone.read().captured_s for _ in range(10)] == list(range(21, 31))
    assert ear.caught_up == 1
    outlet.request_stop()
    ear.blocks.release()
    outlet.stop()
    link.detach(GONE)
    ours.close()
    outlet._answers._thread.join()
    theirs.close()


def yuv(*shape: int) -> Any:
    return np.zeros(shape, np.uint8)


@pytest.mark.parametrize(
    "picture",
    [
        None,
        "a picture",
        Picture(None, 1.0),  # type: ignore[arg-type]
        Picture(yuv(48, 32).astype(np.float64), 1.0),
        Picture(yuv(32, 32, 3), 1.0),
        Picture(yuv(47, 32), 1.0),
        Picture(yuv(48, 31), 1.0),
        Picture(yuv(0, 0), 1.0),
        Picture(yuv(3, 2), math.nan),
        Picture(yuv(3, 2), 1.0, math.nan),
        Picture(yuv(3, 2), 1.0, -0.1),
        Picture(yuv(3, 2), None),  # type: ignore[arg-type]
        Picture(np.broadcast_to(np.uint8(0), (48, 4000)), 1.0),
    ],
)
def test_an_invalid_picture_is_refused(picture: object) -> None:
    """The sentence says what it is instead."""
    with pytest.raises(SourceError, match=r"^The camera delivers .*; it must be a Picture"):
        checked_picture(picture)


@pytest.mark.parametrize(
    "sound",
    [
        None,
        Sound(None, 1.0),  # type: ignore[arg-type]
        Sound(np.zeros(480), 1.0),  # type: ignore[arg-type]
        Sound(np.zeros((480, 3), np.int16), 1.0),
        Sound(np.zeros((1, 480, 2), np.int16), 1.0),
        Sound(np.zeros(0, np.int16), 1.0),
        Sound(np.zeros(50_000, np.int16), 1.0),
        Sound(np.zeros(480, np.int16), math.inf),
    ],
)
def test_invalid_sound_is_refused(sound: object) -> None:
    """The sentence says what it is instead."""
    with pytest.raises(SourceError, match=r"^The microphone delivers .* samples of the shape"):
        checked_sound(sound)


def test_valid_pictures_and_sound_pass() -> None:
    """The checks accept valid pictures and sound of any size."""
    for picture in (Picture(yuv(3, 2), 0.0), Picture(yuv(3240, 3840), 1)):
        assert checked_picture(picture) is picture
    for samples in (np.zeros(1, np.int16), np.zeros((480, 2), np.int16)):
        sound = Sound(samples, 1.0)
        assert checked_sound(sound) is sound
