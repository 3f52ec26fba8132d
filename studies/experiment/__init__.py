"""A packing of glass beads in an oedometer, predicted with each law and compared with a measurement (see `oedometer`)."""
