"""What one viewer is sent, and how its two streams are kept in step: `live` or as in the thesis."""
