"""Checks of laws."""
