"""Turns the tape into a dataset from which a robot can learn to drive.

`episodes` and `frames` decide what an episode and a frame are, and are pure; the other modules read
the tape and write LeRobot's format.
"""
