"""The driver for a robot that speaks ROS 2: directly by DDS, or through rosbridge.

This machine needs no ROS: the driver implements the wire format.

- `driver` is what the server sees; `conversation` decides what to send and when (`pace`), and
  evaluates what the robot publishes (`senses`); `session` has the threads.
- `link` is one connection, with the message type of the commands: `dds_link` or `rosbridge_link`.
- `command_topic` checks who else publishes commands and who subscribes to them; the `standby` stops
  the robot if our process is killed.
"""
