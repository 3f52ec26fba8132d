"""Words about each law: the first paragraphs of its page and its rows in the tables of laws. Groups of laws."""

from typing import NamedTuple


class Words(NamedTuple):
    """A law in words."""

    physics: str  # how the contact deforms
    use: str  # "Use it for ..." on the law's page
    brief: str  # the same in the tables; neighbours with equal words share a row of README
    valid: str  # range of validity, in the table of docs/laws.md


WORDS = {
    "hertz": Words(
        "Two smooth elastic spheres flatten where they touch. The contact area grows with the overlap, so the "
        "stiffness grows with the cube root of the force.",
        "smooth grains such as glass beads, and as the reference for every other law",
        "smooth elastic spheres; the reference",
        "no roughness",
    ),
    "rms": Words(
        "The highest points of a rough surface touch first and spread the load over a larger area than Hertz's; with "
        "increasing load the contact approaches that of smooth spheres.",
        "rough grains of which only the rms roughness is known, at loads with α below 1",
        "rough surfaces of known roughness only",
        "α ≤ 1; doubtful above 5",
    ),
    "pohrt-popov": Words(
        "A self-affine rough surface touches at more and more spots as the force grows: the stiffness is a power of "
        "the force whose exponent follows from the fractal dimension. Above a threshold force F the contact is "
        "complete and as stiff as Hertz's.",
        "rough rock, ballast and sand whose bulk stays elastic; the recommended law for granite",
        "**rough rock and ballast**, elastic bulk",
        "Df 2 to 3, elastic bulk",
    ),
    "goddard": Words(
        "The tip of the contact is a blunt cone. It is pressed flat up to the force P*, above which the sphere acts.",
        "grains with a known slope of their asperities, in analytical comparisons",
        "asperities of known slope",
        "elastic bulk",
    ),
    "rough-plastic": Words(
        "Roughness makes the contact soft at low load, as in any rough law. When the bulk yields at the pressure p_y "
        "the stiffness stops growing. A corner that is sharp under the microscope and blunt in a photo has two radii: "
        "roughness acts on R, yield and unloading on `bulk_radius`.",
        "rough contacts at loads that leave visible plastic marks; needs a measured yield pressure",
        "rough contacts whose bulk yields at a measured pressure",
        "measured p_y",
    ),
    "bahrami": Words(
        "Gaussian asperities yield plastically while the bulk stays elastic; a compact formula gives the pressure "
        "distribution.",
        "hard rough surfaces of known hardness, as a table",
        "Gaussian asperities that yield",
        "p0′ ≥ 0.01; elastic unloading only",
    ),
    "yip-venart": Words(
        "A crust of Gaussian asperities yields at the hardness and rests on an elastic half-space; both are solved together.",
        "reference calculations for plastic asperities",
        "Gaussian asperities that yield: reference",
        "p(0) up to 0.6 H_m",
    ),
    "greenwood-tripp": Words(
        "Elastic Gaussian asperities of equal radius cover the sphere; asperities and the bulk are solved together.",
        "reference calculations for elastic asperities",
        "Gaussian asperities, elastic: reference",
        "elastic bulk",
    ),
    "asperity": Words(
        "The measured height map is cut at the overlap. Each patch of contact is an elastic-plastic ellipsoid with "
        "the patch's area and volume.",
        "one pair of surfaces with a measured height map",
        "a measured height map",
        "one map, one material",
    ),
    "thornton-ning": Words(
        "A smooth sphere is elastic until the pressure in its middle reaches p_y; from there the pressure is limited "
        "and the stiffness is constant. Yielding leaves a flatter surface.",
        "impacts of smooth metal or polymer spheres with a fitted p_y",
        "smooth elastic-plastic spheres",
        "p_y fitted",
    ),
    "jackson-green": Words(
        "A smooth elastic–perfectly plastic sphere becomes softer from first yield to full plasticity, and its hardness "
        "falls as the contact grows. The equations are fits of finite elements.",
        "smooth metal spheres of known yield strength",
        "smooth elastic-plastic spheres",
        "elastic–perfectly plastic",
    ),
    "kogut-etsion": Words(
        "Fits of finite elements describe a smooth sphere in three ranges of overlap, from elastic to nearly fully plastic.",
        "smooth metal spheres of known yield strength, up to 110 ω_c",
        "smooth elastic-plastic spheres",
        "up to 110 ω_c",
    ),
    "conical-damage": Words(
        "A sharp tip crushes as soon as the pressure reaches the strength σ_max, and becomes blunter: its radius "
        "grows with depth.",
        "ballast whose strength and angle were calibrated on bulk tests",
        "laws calibrated on bulk tests",
        "calibrated, ballast",
    ),
    "walton-braun": Words(
        "Two straight lines: loading with k1 and unloading with a larger k2. The difference is the energy loss.",
        "fast simulations with a calibrated coefficient of restitution",
        "laws calibrated on bulk tests",
        "calibrated, given restitution",
    ),
    "luding": Words(
        "Like Walton and Braun's law, with an unloading stiffness that grows with the largest overlap up to a limit.",
        "powders calibrated on bulk tests, without cohesion",
        "laws calibrated on bulk tests",
        "calibrated, powders",
    ),
    "eepa": Words(
        "A contact that is plastic from the first load, with unloading along a stiffer curve of the same power.",
        "powders and soils calibrated on bulk tests, without adhesion",
        "laws calibrated on bulk tests",
        "calibrated, powders and soils",
    ),
}

GROUPS = {
    "Laws of rough contacts": (
        "hertz",
        "rms",
        "pohrt-popov",
        "goddard",
        "bahrami",
        "yip-venart",
        "greenwood-tripp",
        "asperity",
    ),
    "Laws of yielding contacts": ("rough-plastic", "thornton-ning", "jackson-green", "kogut-etsion"),
    "Laws calibrated on bulk tests": ("conical-damage", "walton-braun", "luding", "eepa"),
}
"""Group → its laws; `hertz` is the smooth reference of the rough ones."""
