"""HTTP: the built page, and the requests that do without a data channel.

Whose connections and requests are served, when and how often (of each route and of wrong secrets:
`routes`) is decided here; handlers ask `wax.access` who may do what, and leave the act to
`wax.session`.
"""
