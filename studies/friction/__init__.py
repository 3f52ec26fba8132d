"""What friction that falls with the contact pressure changes: simple shear of spheres at three normal stresses, in LAMMPS."""
