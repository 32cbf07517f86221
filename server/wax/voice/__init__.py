"""The voice to the robot, as far as it is decided (pure): who is heard, when, and how loud."""
