"""How encoded picture and sound become the payloads of RTP packets. Pure, one module a format."""
