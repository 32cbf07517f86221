"""Encoders: each rendition and each encoding of the sound is encoded once for all viewers.

Encoders run in threads. `wax.fanout` and `wax.streams` decide who receives what.
"""
