"""The hand control of a person aboard, as the driver process reads it.

`source` is what every control offers, `line` the frames of one on a serial line of its own.
"""
