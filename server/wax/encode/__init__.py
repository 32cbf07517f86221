"""Encoders: each rendition of the picture and each form of the sound once, for everybody.

Encoders run in threads. Who gets what is decided elsewhere (`wax.fanout`, `wax.streams`).
"""
