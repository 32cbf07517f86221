"""A driver on a line to a robot: our own, and `SteadyRobot` for a plug-in.

`core` and `setpoints` decide what is sent and told, `kept_line` keeps the line open in its threads,
and `robot` is the `Driver` made of both. A driver brings a `RobotLine` of its own, and a `LineCore`
of its own if the robot's protocol decides anything.
"""
