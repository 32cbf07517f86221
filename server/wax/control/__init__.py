"""Who drives, what passes, and the loop that moves the robot.

`turns`, `freshness` and `gate` are pure: they take ``now_s`` as an argument. `loop` is the edge.
"""
