"""Studies: what was measured once with demlaws, and is no part of the package. See README.md."""
