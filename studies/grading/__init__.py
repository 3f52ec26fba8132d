"""Mixtures of large grains and fines in LAMMPS: a heap and a cyclic oedometer with former and present shear."""
