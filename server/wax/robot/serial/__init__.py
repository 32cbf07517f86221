"""A robot on a serial line: a microcontroller, a motor board, or either behind a network.

`frames` is our protocol byte by byte, `bytes_dialect` that of 2004. Threads only in
`port_threads` and `reconnecting_port`; the rest is pure.
"""
