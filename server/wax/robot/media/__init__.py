"""The media process: a robot's own camera, microphone and speaker, away from server and driver.

`process` is the server's end, with `senses` as the sources that it hands out, `outlets` the other;
`messages` defines what is said between them. Started as `python -m wax.robot.media`.
"""
