"""Home automation by MQTT: it is told states and events, and may do what its role may.

`house` decides which messages count, `commands` parses them, `broker` is the connection.
"""
