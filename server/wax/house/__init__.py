"""Home automation by MQTT: it receives states and events, and sends the commands its role permits.

`house` decides which messages count, `commands` parses them. `broker` keeps the link connected;
for each `connection`, `probes` test whether commands arrive and `publications` track what was sent.
"""
