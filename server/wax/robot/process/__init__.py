"""The driver process: it stops the robot when the server is silent or gone.

`driver` is the server's end, `child_loop` and `driver_watchdog` the other; `pipe_messages` defines
the messages between them. Started as `python -m wax.robot.process`.
"""
