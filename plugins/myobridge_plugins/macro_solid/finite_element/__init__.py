"""Finite-element solid."""
