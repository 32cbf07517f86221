"""A media file or a stream address as a camera and a microphone that stay in step.

One demuxer reads, two decoders follow. Live devices are in `wax.capture`.
"""
