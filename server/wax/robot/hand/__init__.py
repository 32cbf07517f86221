"""The hand control of a person aboard, as the driver process reads it.

`source` is the interface of every control, `line` the frames of one on its own serial line.
"""
