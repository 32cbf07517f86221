"""Microphones: 48 kHz whatever the device does, a bounded queue, and errors as sentences."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from structlog.testing import capture_logs
from tests.fake_portaudio import OneDevice
from tests.turned_clock import TurnedClock

from wax.capture import microphone
from wax.capture import portaudio as portaudio_module
from wax.capture.microphone import PortAudioMicrophone
from wax.capture.portaudio import load_portaudio
from wax.config.audio import AudioSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path


class FakePortAudio(OneDevice):
    """PortAudio with one input."""

    InputStream = OneDevice.stream

    def deliver(
        self,
        samples: np.ndarray[Any, np.dtype[np.int16]],
        *,
        adc_s: float = 0.0,
        now_s: float = 0.0,
        overflow: bool = False,
    ) -> None:
        times = SimpleNamespace(inputBufferAdcTime=adc_s, currentTime=now_s)
        block = np.repeat(samples.reshape(-1, 1), self.channels, axis=1)
        self.streams[-1].callback(
            block, len(block), times, SimpleNamespace(input_overflow=overflow)
        )


def make(portaudio: FakePortAudio, clock: TurnedClock, **more: Any) -> PortAudioMicrophone:
    return PortAudioMicrophone(AudioSettings(), clock, load_portaudio=lambda: portaudio, **more)


def block(first: int = 1) -> np.ndarray[Any, np.dtype[np.int16]]:
    return (first + np.arange(480)).astype(np.int16)


def test_blocks_of_10_ms_at_low_latency() -> None:
    """PortAudio is asked for 10 ms blocks at 48 kHz, which are read unchanged."""
    portaudio, clock = FakePortAudio(), TurnedClock()
    source = make(portaudio, clock, device="Webcam")
    source.open()
    stream = portaudio.streams[-1]
    assert (stream.blocksize, stream.latency, stream.device) == (480, "low", "Webcam")
    portaudio.deliver(block())
    assert np.array_equal(source.read().samples, block())
    source.close()
    assert stream.ended == 2


def test_a_stream_that_does_not_start_is_closed() -> None:
    """A stream that fails to start is closed, or the next attempt would find the device in use."""
    portaudio = FakePortAudio()
    portaudio.starts = False
    source = make(portaudio, TurnedClock())
    with pytest.raises(SourceError, match="Device unavailable"):
        source.open()
    assert [stream.ended for stream in portaudio.streams] == [1] * len(portaudio.streams)
    assert portaudio.streams
    portaudio.starts = True
    source.open()
    assert portaudio.looked == 1, "none counts as open"
    source.close()


@pytest.mark.parametrize(
    ("adc_s", "now_s", "age_s"),
    [(50.0, 50.025, 0.025), (0.0, 50.0, 0.010), (50.0, 50.0, 0.010), (3.0, 50.0, 0.010)],
)
def test_capture_time(adc_s: float, now_s: float, age_s: float) -> None:
    """The converter's time is used where it is credible, else arrival minus the block's length."""
    portaudio, clock = FakePortAudio(), TurnedClock(100.0)
    source = make(portaudio, clock)
    source.open()
    portaudio.deliver(block(), adc_s=adc_s, now_s=now_s)
    clock.time_s += 5
    assert source.read().captured_s == pytest.approx(100 - age_s)
    source.close()


def test_a_sound_servers_guess_moves_no_sound() -> None:
    """A wrong age for some blocks makes no gap; sound that was really lost soon does."""
    portaudio, clock = FakePortAudio(), TurnedClock()
    source = make(portaudio, clock)
    source.open()

    def hear(blocks: int, age_s: float = 0.025, *, overflow: bool = False) -> list[float]:
        """Return each block's capture time, relative to the true time."""
        errors_s = []
        for _ in range(blocks):
            clock.time_s += 0.01
            portaudio.deliver(block(), adc_s=50.0, now_s=50.0 + age_s, overflow=overflow)
            overflow = False
            errors_s.append(source.read().captured_s - (clock.time_s - 0.025))
        return errors_s

    assert hear(60) + hear(30, 0.24) + hear(60) == pytest.approx([0.0] * 150, abs=1e-6)
    clock.time_s += 0.2
    assert hear(1, overflow=True) == pytest.approx([0.0], abs=1e-6)
    hear(99)
    clock.time_s += 0.2
    assert hear(60)[-1] == pytest.approx(0.0, abs=1e-6)
    clock.time_s += 30.0
    assert hear(1) == pytest.approx([0.0], abs=1e-6)
    source.close()


@pytest.mark.parametrize(("rate_hz", "channels"), [(44_100, 2), (16_000, 1), (48_000, 2)])
def test_a_device_of_another_rate_is_converted(rate_hz: int, channels: int) -> None:
    """A device that cannot do 48 kHz is resampled, and tone, times and channels are kept."""
    portaudio, clock = FakePortAudio(rate_hz, channels), TurnedClock()
    source = make(portaudio, clock)
    source.open()
    length = rate_hz // 100
    assert portaudio.streams[-1].blocksize == length
    sounds = []
    for index in range(40):
        phase = (index * length + np.arange(length)) * (2 * np.pi * 1000 / rate_hz)
        clock.time_s = 100 + (index + 1) * length / rate_hz
        portaudio.deliver(np.round(8000 * np.sin(phase)).astype(np.int16))
        while not source._blocks.empty():
            sounds.append(source.read())
    source.close()
    assert {sound.channels for sound in sounds} == {channels}
    joined = np.concatenate([sound.samples for sound in sounds])
    samples = joined if channels == 1 else joined[:, 1]
    assert len(samples) == pytest.approx(40 * 480, abs=100)
    spectrum = np.abs(np.fft.rfft(samples[4800:9600] * np.hanning(4800)))
    assert np.argmax(spectrum) * 10 == 1000
    counted = np.cumsum([0, *[len(sound.samples) for sound in sounds[:-1]]]) / 48_000
    times = np.array([sound.captured_s for sound in sounds]) - 100
    assert np.abs(times - counted).max() < 0.002


def test_a_card_can_be_named_by_its_socket(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One of two identical cards is named by socket; its number is looked up at each opening."""
    monkeypatch.setattr(portaudio_module, "SOUND_CARDS", tmp_path)
    link = tmp_path / "usb-0:1:1.0"
    fake = FakePortAudio()
    source = make(fake, TurnedClock(), device=str(link))
    for number in (1, 12):
        link.unlink(missing_ok=True)
        link.symlink_to(tmp_path / f"controlC{number}")
        source.open()
    source.close()
    assert [stream.device for stream in fake.streams] == ["hw:1,", "hw:12,"]


def test_two_capsules_are_two_channels() -> None:
    """Left and right arrive as the device delivers them, not swapped or mixed."""
    portaudio = FakePortAudio(channels=2)
    source = make(portaudio, TurnedClock())
    source.open()
    both = np.column_stack((block(1), block(9000)))
    times = SimpleNamespace(inputBufferAdcTime=0.0, currentTime=0.0)
    portaudio.streams[-1].callback(both, 480, times, SimpleNamespace(input_overflow=False))
    assert np.array_equal(source.read().samples, both)
    source.close()


def test_one_channel_is_enough_and_said() -> None:
    """A device with one channel gives mono, and the log says so once per opening."""
    portaudio = FakePortAudio(channels=1)
    source = make(portaudio, TurnedClock())
    with capture_logs() as logs:
        source.open()
    assert [log["event"] for log in logs] == ["the microphone has one channel: its sound is mono"]
    portaudio.deliver(block())
    assert source.read().samples.shape == (480,)
    source.close()


def test_a_device_of_two_channels_can_be_mono() -> None:
    """With `channels = 1` a device that only offers two is downmixed without a log line."""
    portaudio = FakePortAudio(channels=2)
    settings = AudioSettings(channels=1)
    source = PortAudioMicrophone(settings, TurnedClock(), load_portaudio=lambda: portaudio)
    with capture_logs() as logs:
        source.open()
    assert (portaudio.streams[-1].channels, logs) == (2, [])
    portaudio.deliver(np.full(480, 5000, np.int16))
    sound = source.read()
    assert sound.channels == 1
    assert sound.samples[100:-100] == pytest.approx(5000, abs=2)
    source.close()


def test_a_slow_reader_loses_the_oldest() -> None:
    """At most half a second is queued; losses are logged once in 10 s."""
    portaudio, clock = FakePortAudio(), TurnedClock()
    source = make(portaudio, clock)
    source.open()
    with capture_logs() as logs:
        portaudio.deliver(block(0))
        source.read()
        assert logs == []
        for number in range(60):
            portaudio.deliver(block(number), overflow=number == 0)
        assert source.read().samples[0] == 10
        for _ in range(2):
            portaudio.deliver(block(0), overflow=True)
            source.read()
        assert [log["blocks"] for log in logs] == [11]
        clock.time_s += 10
        source.read()
        source.read()
        assert [log["blocks"] for log in logs] == [11, 2]
    source.close()


def test_a_rest_is_no_loss() -> None:
    """After a rest the next block is read, those before it are dropped, and nothing is logged."""
    portaudio, clock = FakePortAudio(), TurnedClock()
    source = make(portaudio, clock)
    source.open()
    with capture_logs() as logs:
        for number in range(90):
            portaudio.deliver(block(number))
        source.catch_up()
        portaudio.deliver(block(90))
        assert source.read().samples[0] == 90
    assert logs == []
    source.close()


def test_a_silent_device_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """A microphone that delivers nothing is an error that says what to do."""
    monkeypatch.setattr(microphone, "_SILENT_S", 0.01)
    source = make(FakePortAudio(), TurnedClock())
    source.open()
    with pytest.raises(SourceError, match=r"^The microphone delivers no sound; check its cable"):
        source.read()
    source.close()


def test_a_missing_device_is_looked_for_again() -> None:
    """A missing device is a sentence; at the next attempt PortAudio rescans and finds it."""
    portaudio = FakePortAudio(present=False)
    source = make(portaudio, TurnedClock(), device=2)
    with pytest.raises(SourceError, match=r"^Microphone 2 cannot be opened \(Error querying"):
        source.open()
    assert portaudio.looked == 0
    portaudio.present = True
    source.open()
    assert portaudio.looked == 1
    source.close()


def test_without_the_library_the_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where PortAudio is not installed, the sentence says what to install."""

    def fail(name: str) -> None:
        raise OSError("PortAudio library not found")

    monkeypatch.setattr("importlib.import_module", fail)
    with pytest.raises(SourceError, match="apt install libportaudio2"):
        load_portaudio()


def test_a_name_that_fits_several_says_which() -> None:
    """A name that fits several devices lists them with the numbers and names to choose from."""
    portaudio = FakePortAudio()
    several = "Multiple input devices found for 'USB':\n[2] USB Mic, ALSA\n[3] USB Cam, ALSA"

    def query_devices(*_: object) -> dict[str, float]:
        raise ValueError(several)

    portaudio.query_devices = query_devices  # type: ignore[assignment, method-assign]
    named = PortAudioMicrophone(
        AudioSettings(), TurnedClock(), device="USB", load_portaudio=lambda: portaudio
    )
    with pytest.raises(SourceError, match=r"for 'USB': \[2\] USB Mic, ALSA; \[3\] USB Cam, ALSA"):
        named.open()
