"""Home automation by MQTT: told what goes on, and heard where its role in the permissions may."""
