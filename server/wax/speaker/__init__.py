"""Plays the voice at the robot: outputs, the thread that feeds one, and the decoder.

It is the counterpart of `wax.capture`.
"""
