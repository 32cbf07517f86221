"""Pictures and sound become packets, once for everybody."""
