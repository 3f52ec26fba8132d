"""The stone of the published tests, and what is taken where nothing is known of a material."""

from demlaws.contact import Material

DENSITY = 2650.0
"""Density [kg/m³] of a material that states none: quartz."""

GRANITE = Material(young=60.6e9, poisson=0.25, hardness=639 * 9.80665e6, density=2680.0)
"""Mount Sorrel granite: Table 1 of Altuhafi, Baudet & Coop 2023 (639 kgf/mm², 6.266 GPa)."""

GRANITE_YIELD_PRESSURE = 1.66e9
"""p_y [Pa] of the rough-plastic law for its spheres and the cone RFC10: 0.265 of the hardness."""
