"""The driver in a process of its own: it stops the robot when the server is silent or gone."""
