"""Loads: what acts on the named parts of a boundary."""
