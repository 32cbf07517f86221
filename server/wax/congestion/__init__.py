"""Pure: what one viewer's link carries, and what is sent over it and when."""
