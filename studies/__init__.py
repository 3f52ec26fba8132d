"""Measurements with demlaws that are not part of the package. See README.md."""
