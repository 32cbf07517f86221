"""The driver in a process of its own: it stops the robot when the server is silent or gone.

`driver` is the server's end, `child_loop` and `driver_watchdog` the other; `pipe_messages` is what
they say. Started as `python -m wax.robot.process`.
"""
