"""The driver for a robot that speaks ROS 2: straight into DDS, or by rosbridge.

No ROS is needed on this machine; the messages are what is on the wire.

- `driver` is what the server sees; `conversation` says what the robot is told and when (`pace`),
  and what it tells (`senses`); `session` has the threads.
- `link` is one connection, with the type of the commands: a `dds_link` or a `rosbridge_link`.
- `command_topic` judges the topic of the commands: who else publishes, and who listens; the
  `standby` stops the robot where our process is killed.
"""
