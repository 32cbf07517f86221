"""What is remembered: who came, who drove, who stopped the robot, and what the host did.

One thread writes it to one SQLite file; nothing here delays or stops driving. The server itself
reads only what must outlive it: bans, invitations used and hosts' cookies, once at the start.
"""
