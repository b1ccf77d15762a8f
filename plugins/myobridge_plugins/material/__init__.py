"""Materials: the passive laws of the tissue."""
