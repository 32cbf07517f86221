"""Everybody who is here: admission, what each page says and is told, who may stop.

The room stays small: what is decided about driving is in `wax.control`, about media in
`wax.streams`. No sockets and no aiortc here.
"""
