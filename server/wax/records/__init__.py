"""A history of who came, who drove, who stopped the robot, and what the host did.

One thread writes it to one SQLite file; nothing here delays or stops driving. The server itself
reads back only what must survive a restart: bans, used invitations and hosts' cookies.
"""
