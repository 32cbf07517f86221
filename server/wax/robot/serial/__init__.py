"""A robot on a serial line: a microcontroller, a motor board, or either behind a network."""
