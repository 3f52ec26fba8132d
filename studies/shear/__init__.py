"""Shear of contacts: energy of a closed gas in each engine, oblique impacts compared with measurements, loops."""
