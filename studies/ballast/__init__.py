"""A bed of ballast under a plate with cyclic load: effects of the contact law, roughness and the shear model (see `bed`)."""
