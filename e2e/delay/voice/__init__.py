"""The suite of the voice to the robot."""
