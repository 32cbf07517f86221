"""What plays the voice at the robot: outputs, the thread that feeds one, and the decoder.

The other direction of `wax.capture`.
"""
