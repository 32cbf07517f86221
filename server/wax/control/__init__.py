"""Who drives, what passes, and the loop that moves the robot.

All is pure (``now_s`` is an argument) but `loop` and `safe_driver`, which calls the driver.
What becomes of a command, in the order in which it is asked:

1. `stop_latch` - is a stop pressed? Then nothing moves until it is released.
2. `turns`, `turn_view` - is it the turn of whoever sends, and are they connected?
3. `gate` - is it the next of this turn's commands, and was neutral seen since the last fault?
4. `command_freshness` - was it sent a moment ago, over a line that is short enough?
5. `video_freshness` - does its sender see where the robot goes?
6. `speed`, `stopping_distance` - how fast may it be, and can the robot stop in time?
7. `ramp` - and how soon?

`rules` holds what they take from the configuration, `reasons` what they answer when they refuse.
No rule imports a robot, the session or media.
"""
