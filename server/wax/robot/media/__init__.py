"""The media process: a robot's camera, microphone and speaker, apart from server and driver.

`process` is the server's end, which provides the sources in `senses`; `outlets` is the process's
end; `messages` defines the messages between them. It is started as `python -m wax.robot.media`.
"""
