"""HTTP: the built page, and the requests that need no data channel.

It decides whose connections and requests are served, when and how often (`routes` has the rate
limits of each route and of wrong secrets). Handlers ask `wax.access` for permission, and
`wax.session` acts.
"""
