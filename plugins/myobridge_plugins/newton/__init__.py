"""Newton's methods."""
