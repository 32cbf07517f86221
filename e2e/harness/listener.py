"""Somebody who listens to the simulated robot as a viewer does: through Opus, with both ears."""

from __future__ import annotations

from typing import TYPE_CHECKING

import av
import numpy as np
from av.packet import Packet

from wax.capture.audio_blocks import Blocks
from wax.capture.channel_faults import ChannelFaults
from wax.capture.source import SAMPLE_RATE_HZ, Sound
from wax.encode.sample_clock import SampleClock
from wax.encode.sound_encoder import SoundEncoder
from wax.robot.simulated.hearing import SoundMixer

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.congestion.allocation import SoundEncoding
    from wax.robot.simulated.simulation import Senses
    from wax.robot.simulated.world import World


class Listener:
    """Each block goes the server's way: capsules, blocks, encoder; then a viewer's decoder."""

    def __init__(self, world: World, encoding: SoundEncoding, seed: int = 1) -> None:
        self._mixer = SoundMixer(world, seed)
        self._channel_faults = ChannelFaults(lambda _: None)
        self._blocks = Blocks()
        self._clock = SampleClock()
        self._encoder = SoundEncoder(encoding)
        decoder = av.CodecContext.create("libopus", "r")
        assert isinstance(decoder, av.AudioCodecContext)
        decoder.sample_rate, decoder.layout, decoder.format = SAMPLE_RATE_HZ, "stereo", "s16"
        self._decoder = decoder

    def hear(self, senses: Senses) -> NDArray[np.int16]:
        """Return what comes out of the decoder for the next 10 ms, as ``(n, 2)``; n may be 0."""
        heard: list[NDArray[np.int16]] = [np.zeros((0, 2), np.int16)]
        sound = self._channel_faults.push(Sound(self._mixer.block(senses), senses.at_s))
        for block in self._blocks.push(sound):
            packet = self._encoder.encode(block, self._clock.stamp(block.captured_s))
            if packet is not None:
                frames = self._decoder.decode(Packet(packet.data))
                heard += [np.asarray(one.to_ndarray(), np.int16).reshape(-1, 2) for one in frames]
        return np.concatenate(heard)
