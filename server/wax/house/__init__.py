"""Home automation by MQTT: it is told states and events, and may do what its role may.

`house` decides which messages count, `commands` parses them. `broker` stays connected; of each
`connection`, `probes` try whether commands arrive, and `publications` are what it has said.
"""
