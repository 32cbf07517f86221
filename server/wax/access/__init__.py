"""Who somebody is, and what they may: secrets, invitations, bans, and the permission table.

Pure: no sockets, no files; times are given. Who is connected lives in `wax.session`.
"""
