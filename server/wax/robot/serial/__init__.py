"""A robot on a serial port: a microcontroller, a motor board, or either behind a network.

`frames` is our protocol byte by byte, `bytes_dialect` that of 2004, `text_dialect` whatever lines
of text the host's board understands. Only `port_threads` and `reconnecting_port` use threads; the
rest is pure.
"""
