"""Posts events to programs of the host's: bounded, Stop before news, lost and not waited for."""
