"""Solids: what the fibres pull on."""
