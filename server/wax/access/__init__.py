"""Who somebody is, and what they may: secrets, invitations, bans, and the permission table.

Pure but for `secret_file` and `host_link`, which keep secrets on disk. Who is connected lives in
`wax.session`.
"""
