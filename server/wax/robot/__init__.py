"""The robot: one driver interface, and the robots that speak it."""
