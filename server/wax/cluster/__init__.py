"""Observers past one machine: rooms of a media engine, into which the robot publishes.

The queue, driving and Stop stay with the robot; what is here carries picture and sound to whoever
only watches, and tells them of the room. LiveKit is the engine; any other is reached by WHIP.
"""
