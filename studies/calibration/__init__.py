"""Roughness and modulus of a law by GrainLearning, from a contact test and from a bulk test in YADE."""
