"""What viewers, a crowd, the tape, the page and rooms of LiveKit cost: same work, same machine."""
