"""A media file or stream address as a camera and a microphone in sync.

One demuxer feeds two decoders. Local devices are in `wax.capture`.
"""
