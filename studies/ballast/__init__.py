"""A bed of ballast under a plate with cyclic load: what the contact law, roughness and the shear model change (see `bed`)."""
