"""Filament overlap as a function of stretch."""
