"""The connected viewers: admission, messages from and to their pages, who may stop.

Decisions about driving are in `wax.control`, about media in `wax.streams`. No sockets and no
aiortc here.
"""
