"""Plugins that ship with myobridge, registered through the same entry points as a stranger's package."""
