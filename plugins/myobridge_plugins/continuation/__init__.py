"""Continuation strategies."""
