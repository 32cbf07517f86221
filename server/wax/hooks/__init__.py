"""Posts events to programs of the host's: bounded, in order, and lost rather than waited for."""
