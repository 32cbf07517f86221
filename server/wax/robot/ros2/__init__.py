"""The driver for a robot that speaks ROS 2: straight into DDS, or by rosbridge.

No ROS is needed on this machine; the messages are what is on the wire.
"""
