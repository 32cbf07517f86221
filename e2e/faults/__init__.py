"""Each link from finger to wheel is broken while the robot drives, and the stop is timed."""
