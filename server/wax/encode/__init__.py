"""Encoders: each rendition of the picture and each form of the sound is encoded once.

Encoders run in threads. `wax.fanout` and `wax.streams` decide who gets what.
"""
