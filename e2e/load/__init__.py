"""The cost of viewers, a crowd, the tape, the page and LiveKit rooms, on one machine."""
