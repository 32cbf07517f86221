"""source → newest-frame slot → encoder (one per rendition) → fan-out → lane (one per viewer)."""
