"""One module for each entrance: pages, offers, the network, the serial line, files."""
