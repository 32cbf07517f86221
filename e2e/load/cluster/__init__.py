"""Observers beyond one machine, tried with the real LiveKit: two nodes on one Redis."""
