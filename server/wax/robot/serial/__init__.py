"""A robot on a serial port: a microcontroller, a motor board, or either behind a network.

`frames` is our protocol byte by byte, `bytes_dialect` that of 2004, `text_dialect` is for boards
with a text protocol of their own. Only `port_line` does io, in the threads of `robot/line`; the
rest is pure.
"""
