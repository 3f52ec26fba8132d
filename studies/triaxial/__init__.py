"""The cyclic triaxial test of ballast in LAMMPS, compared with the measured one (see `cell`, `cycles`)."""
