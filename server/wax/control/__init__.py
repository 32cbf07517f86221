"""Who drives, which commands count, and the loop that moves the robot.

README.md draws how a command is judged, and by which module; TURNS.md how people take turns.
All of it is pure (``now_s`` is an argument) but `loop`, `controls_loop` and `safe_driver`, which
call the driver. No rule imports a robot, the session or media.
"""
