"""Encoders: each rendition of the picture and each encoding of the sound is made once.

Encoders run in threads. `wax.fanout` and `wax.streams` decide who gets what.
"""
