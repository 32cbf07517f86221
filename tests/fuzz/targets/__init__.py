"""One module for each way in: pages, offers, the network, the serial line, files."""
