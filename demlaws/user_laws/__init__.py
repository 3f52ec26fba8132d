"""User-defined laws: made from plain functions, and checked."""
