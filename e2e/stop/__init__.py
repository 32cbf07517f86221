"""Breaks each link from finger to wheel while the robot drives, and times the stop."""
