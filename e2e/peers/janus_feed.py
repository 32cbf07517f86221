"""Feed Janus's streaming plugin by RTP: `python -m e2e.peers.janus_feed AUDIO_PORT VIDEO_PORT`.

The test card as every peer sends it, encoded once: VP8 640×480 at 30 fps and 1 Mbit/s, Opus of 20
ms. It cannot be asked for a keyframe, so there is one every two seconds, which Janus keeps for
newcomers.
"""

from __future__ import annotations

import socket
import sys
import threading
from typing import TYPE_CHECKING, Final

from e2e.peers.media import sources
from e2e.peers.sizes import FPS, VGA
from wax.config.video import RenditionSettings
from wax.congestion.allocation import SoundEncoding
from wax.encode.sample_clock import SampleClock
from wax.encode.sound_encoder import SoundEncoder
from wax.encode.video_encoder import VideoEncoder
from wax.rtc.payload.vp8 import Vp8Packetizer
from wax.rtc.rtp import Packet

if TYPE_CHECKING:
    from wax.capture.source import AudioSource, VideoSource

_AUDIO_PT: Final = 111
_VIDEO_PT: Final = 96
_KEYFRAME_EVERY: Final = 60
_PAYLOAD_BYTES: Final = 1200


class Stream:
    """One stream to a port on this machine."""

    def __init__(self, port: int, payload_type: int) -> None:
        self._socket = socket.socket(type=socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._payload_type = payload_type
        self._number = 0

    def send(self, pts: int, payload: bytes, *, marker: bool) -> None:
        number, self._number = self._number, (self._number + 1) % 2**16
        ssrc = self._payload_type
        packet = Packet(self._payload_type, number, ssrc, pts % 2**32, marker, payload)
        self._socket.send(packet.to_bytes(b""))


def feed_video(camera: VideoSource, stream: Stream) -> None:
    rendition = RenditionSettings(
        width=VGA.width, height=VGA.height, fps=FPS, bitrate_bps=VGA.bitrate_bps
    )
    encoder = VideoEncoder(codec="vp8", rendition=rendition)
    packetizer = Vp8Packetizer(picture_id=0, tl0_picidx=0)
    number = 0
    while True:
        picture = encoder.encode(camera.read(), keyframe=number % _KEYFRAME_EVERY == 0)
        number += 1
        if picture is None:
            continue
        payloads = packetizer.packets(
            picture.data,
            layer=picture.layer,
            sync=picture.sync,
            droppable=picture.droppable,
            keyframe=picture.keyframe,
            max_bytes=_PAYLOAD_BYTES,
        )
        for index, (head, piece) in enumerate(payloads, 1):
            stream.send(picture.pts, head + piece, marker=index == len(payloads))


def feed_audio(microphone: AudioSource, stream: Stream) -> None:
    clock, encoder = SampleClock(), SoundEncoder(SoundEncoding(20, 32_000))
    while True:
        block = microphone.read()
        sound = encoder.encode(block, clock.stamp(block.captured_s))
        if sound is not None:
            stream.send(sound.pts, sound.data, marker=False)


if __name__ == "__main__":
    audio, video = (
        Stream(int(port), kind)
        for port, kind in zip(sys.argv[1:], (_AUDIO_PT, _VIDEO_PT), strict=True)
    )
    with sources() as (camera, microphone):
        threading.Thread(target=feed_audio, args=(microphone, audio), daemon=True).start()
        feed_video(camera, video)
