"""Fields of fibre directions."""
