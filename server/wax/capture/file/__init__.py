"""A media file or stream address as a source."""
