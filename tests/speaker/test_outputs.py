"""The outputs: a PortAudio device, a file, the simulated robot, a plug-in."""

from __future__ import annotations

import os
import wave
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.fake_portaudio import OneDevice
from tests.speaker.spoken import loudest_hz, tone

from wax.capture import portaudio
from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.config.voice import VoiceSettings
from wax.errors import ConfigError, SourceError, SpeakerError
from wax.robot.serial.driver import SerialRobot
from wax.robot.simulated.robot import SimulatedRobot
from wax.speaker.file import FileSpeaker
from wax.speaker.find_speaker import make_speaker
from wax.speaker.portaudio import PortAudioSpeaker

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

CLOCK = SystemClock()


class FakePortAudio(OneDevice):
    """PortAudio with one output."""

    OutputStream = OneDevice.stream

    def pull(self, frames: int) -> NDArray[np.int16]:
        """Request the next samples as the device would."""
        out = np.full((frames, self.channels), 99, np.int16)
        self.streams[-1].callback(out, frames, None, None)
        return out


def make(fake: FakePortAudio, **more: Any) -> PortAudioSpeaker:
    return PortAudioSpeaker(VoiceSettings(), CLOCK, load_portaudio=lambda: fake, **more)


def test_a_device_pulls_what_was_written() -> None:
    """A device reads blocks of 10 ms at low latency, and silence when nothing is queued."""
    fake = FakePortAudio()
    speaker = make(fake, device="USB")
    speaker.open()
    stream = fake.streams[-1]
    assert (stream.blocksize, stream.latency, stream.device) == (480, "low", "USB")
    sound = tone(440, 0.015)
    speaker.write(sound)
    assert np.array_equal(fake.pull(480)[:, 0], sound[:480])
    assert np.array_equal(fake.pull(480)[:, 0], np.append(sound[480:], np.zeros(240, np.int16)))
    assert not fake.pull(480).any()
    speaker.close()
    assert stream.ended == 2


@pytest.mark.parametrize(("rate_hz", "channels"), [(44_100, 2), (16_000, 1)])
def test_a_device_of_another_rate_is_converted_for(rate_hz: int, channels: int) -> None:
    """A device that cannot do 48 kHz mono plays the tone at its pitch on all channels."""
    fake = FakePortAudio(rate_hz, channels)
    speaker = make(fake)
    speaker.open()
    heard = []
    for begin in range(0, 24_000, 960):
        speaker.write(tone(1000, 0.5)[begin : begin + 960])
        heard.append(fake.pull(rate_hz // 50))
    speaker.close()
    sound = np.concatenate(heard)
    assert sound.shape[1] == channels
    assert np.array_equal(sound[:, 0], sound[:, -1])
    steady = sound[rate_hz // 10 : rate_hz // 10 + rate_hz // 5, 0]
    assert loudest_hz(steady) * rate_hz / 48_000 == pytest.approx(1000, abs=10)


def test_no_more_than_200_ms_wait_for_a_device() -> None:
    """A device that is slower than our clock loses sound but gains no delay."""
    fake = FakePortAudio()
    speaker = make(fake)
    speaker.open()
    for _ in range(50):
        speaker.write(np.ones(960, np.int16))
    waited = 0
    while fake.pull(480).any():
        waited += 480
    assert waited == 9600
    speaker.close()


def test_a_device_that_goes_is_said() -> None:
    """Writing to a stream that the system has ended is an error."""
    fake = FakePortAudio()
    speaker = make(fake)
    speaker.open()
    fake.streams[-1].active = False
    with pytest.raises(SpeakerError, match=r"^The speaker has gone; check its cable"):
        speaker.write(np.ones(480, np.int16))
    speaker.close()


def test_a_missing_device_is_looked_for_again() -> None:
    """Devices are rescanned, but not while a microphone is open, which a rescan would end."""
    fake = FakePortAudio()
    fake.present = False
    speaker = make(fake, device=3)
    with pytest.raises(SpeakerError, match=r"^Speaker 3 cannot be opened \(Error querying"):
        speaker.open()
    microphone = portaudio.start_stream(FakePortAudio().OutputStream(samplerate=48_000, channels=1))
    with pytest.raises(SpeakerError):
        speaker.open()
    assert fake.looked == 0
    portaudio.close_stream(microphone)
    fake.present = True
    speaker.open()
    assert fake.looked == 1
    speaker.close()


@pytest.mark.parametrize(
    ("error", "install"),
    [(OSError("no library"), "apt install libportaudio2"), (ImportError(), "pip install sound")],
)
def test_without_the_library_the_package_is_named(
    monkeypatch: pytest.MonkeyPatch, error: Exception, install: str
) -> None:
    """The sentence says what to install, and what to configure otherwise."""

    def fail(name: str) -> None:
        raise error

    monkeypatch.setattr("importlib.import_module", fail)
    speaker = PortAudioSpeaker(VoiceSettings(), CLOCK)
    with pytest.raises(SpeakerError, match=rf"^Speakers need .*{install}.*\[voice\] speaker"):
        speaker.open()
    with pytest.raises(SourceError, match=rf"^Microphones need .*{install}.*\[audio\] source"):
        portaudio.load_portaudio()


def read(path: Path) -> NDArray[np.int16]:
    with wave.open(str(path)) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (1, 2, 48_000)
        return np.frombuffer(file.readframes(file.getnframes()), np.int16)


def test_a_file_is_whole_after_each_word(tmp_path: Path) -> None:
    """The file is readable while it is written, and the next server appends to it."""
    path = tmp_path / "voice.wav"
    first, second = tone(440, 0.1), tone(880, 0.05)
    speaker = FileSpeaker(path)
    speaker.open()
    speaker.write(first)
    assert np.array_equal(read(path), first)
    again = FileSpeaker(path)
    again.open()
    again.write(second)
    again.close()
    speaker.close()
    assert np.array_equal(read(path), np.concatenate((first, second)))


@pytest.mark.parametrize("content", [b"RIFF", b"x" * 100, b"RIFF\0\0\0\0WAVEfmt " + bytes(60)])
def test_a_file_of_something_else_is_left_as_it_is(tmp_path: Path, content: bytes) -> None:
    """A mistake in the configuration overwrites nobody's recording."""
    path = tmp_path / "other.wav"
    path.write_bytes(content)
    speaker = FileSpeaker(path)
    with pytest.raises(SpeakerError, match="it was left as it is"):
        speaker.open()
    speaker.close()
    assert path.read_bytes() == content


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    """The sentence contains the system's reason."""
    (tmp_path / "voice.wav").mkdir()
    speaker = FileSpeaker(tmp_path / "voice.wav")
    with pytest.raises(SpeakerError, match="Is a directory"):
        speaker.open()
    with pytest.raises(SpeakerError, match="before it was opened"):
        speaker.write(tone(440, 0.01))


def test_a_pipe_is_refused_at_the_start(tmp_path: Path) -> None:
    """Anything but a regular file is refused, for it would lose the voice or block the speaker."""
    pipe = tmp_path / "voice.wav"
    os.mkfifo(pipe)
    settings = VoiceSettings(speaker=str(pipe))
    with pytest.raises(ConfigError, match=r"voice\.wav cannot be read: it is a pipe"):
        make_speaker(settings, CLOCK, SimulatedRobot(RobotSettings(), CLOCK))


def test_the_simulated_robot_hears_itself() -> None:
    """The simulated robot's speech is heard once in both of its microphone's channels."""
    robot = SimulatedRobot(RobotSettings(), CLOCK)
    speaker = make_speaker(VoiceSettings(speaker="robot"), CLOCK, robot)
    assert speaker is not None
    speaker.open()
    microphone = robot.microphone(CLOCK)
    microphone.open()
    speaker.write(tone(3000, 0.1, level=0.5))
    loud = np.concatenate([microphone.read().samples for _ in range(10)])
    after = np.concatenate([microphone.read().samples for _ in range(10)])
    microphone.close()
    speaker.close()
    for ear in range(2):
        assert loudest_hz(loud[:, ear]) == pytest.approx(3000, abs=20)
        assert loudest_hz(after[:, ear]) < 2900


class Own:
    """A plug-in speaker."""

    def __init__(self, settings: VoiceSettings, clock: object) -> None: ...

    def open(self) -> None: ...

    def write(self, samples: object) -> None: ...

    def close(self) -> None: ...


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("none", type(None)),
        ("speaker", PortAudioSpeaker),
        ("speaker:2", PortAudioSpeaker),
        ("speaker:USB", PortAudioSpeaker),
        ("voice.wav", FileSpeaker),
        (f"{__name__}:Own", Own),
    ],
)
def test_a_speaker_is_found_by_its_name(name: str, kind: type) -> None:
    """Each form of the key builds the speaker that it names."""
    driver = SerialRobot(RobotSettings(driver="serial"), CLOCK)
    assert isinstance(make_speaker(VoiceSettings(speaker=name), CLOCK, driver), kind)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("robot", "the serial robot has no speaker of its own"),
        ("loudspeaker", "possible are none, robot, speaker"),
        ("/no/such/folder/voice.wav", "is no folder"),
        ("wax.clock:SystemClock", "failed|has no method open"),
    ],
)
def test_what_cannot_work_is_refused_at_the_start(name: str, problem: str) -> None:
    """An impossible value is refused with the key and what to write instead."""
    driver = SerialRobot(RobotSettings(driver="serial"), CLOCK)
    with pytest.raises(ConfigError, match=rf"^\[voice\] speaker: .*({problem})"):
        make_speaker(VoiceSettings(speaker=name), CLOCK, driver)
