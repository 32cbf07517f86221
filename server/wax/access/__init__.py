"""Identity, admission and permissions: secrets, invitations, bans, and the permission table.

`host_decisions` is what the host has decided for everybody.
`secret_file` keeps the server's secret on disk, `host_link` is a socket, `published_keys` reads
a proxy's keys, and `access` writes to the records; the rest is pure. Connected viewers are in
`wax.session`.
"""
