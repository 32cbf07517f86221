"""The driver process: it stops the robot when the server is silent or gone.

`driver` is the server's end, `child_loop` and `driver_watchdog` the process's; `pipe_messages`
defines the messages between them. It is started as `python -m wax.robot.process`.
"""
