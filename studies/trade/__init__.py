"""Cost against error of laws and evaluations, alone, in an engine's step, and in a packing."""
