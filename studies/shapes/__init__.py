"""What R of a contact changes in a bed of angular grains, and what roughness changes."""
