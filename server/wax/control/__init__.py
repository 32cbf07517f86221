"""Who drives, which commands count, and the loop that moves the robot.

All of it is pure (``now_s`` is an argument) but `loop`, `controls_loop` and `safe_driver`, which
call the driver.
A command is checked in this order:

0. `local_hand` - does the person aboard let an operator drive? They outrank everybody.
1. `stop_latch` - is a stop in force? Then nothing moves until it is released.
2. `turns`, `turn_view` - is it the sender's turn, and are they connected?
3. `gate` - is it the next of this turn's commands, and was neutral seen since the last fault?
4. `command_freshness` - was it sent recently, over a link with an acceptable delay?
5. `video_freshness` - does its sender see where the robot is going?
6. `speed`, `stopping_distance` - how fast may it be, and can the robot stop in time?
7. `ramp` - how quickly may the speed change?

Lamps, grippers and the like are `controls`, checked in the same way.

`rules` holds the configuration of all this, `reasons` the sentences for refusals and limits.
No rule imports a robot, the session or media.
"""
