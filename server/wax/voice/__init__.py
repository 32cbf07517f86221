"""Decides about the voice to the robot: who is heard, when, and how loud (pure)."""
