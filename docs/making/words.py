"""Law → (what deforms, when to use the law), in words; the first paragraphs of the law's page. Groups of laws."""

WORDS = {
    "hertz": (
        "Two smooth elastic spheres flatten where they touch. The contact area grows with the overlap, so the "
        "stiffness grows with the cube root of the force.",
        "smooth grains such as glass beads, and as the reference for every other law",
    ),
    "rms": (
        "The highest points of a rough surface touch first and spread the load over a larger area than Hertz's; with "
        "increasing load the contact approaches that of smooth spheres.",
        "rough grains of which only the rms roughness is known, at loads with α below 1",
    ),
    "pohrt-popov": (
        "A self-affine rough surface touches at more and more spots as the force grows: the stiffness is a power of "
        "the force whose exponent follows from the fractal dimension. Above a threshold force F the contact is "
        "complete and as stiff as Hertz's.",
        "rough rock, ballast and sand whose bulk stays elastic; the recommended law for granite",
    ),
    "goddard": (
        "The tip of the contact is a blunt cone. It is pressed flat up to the force P*, above which the sphere acts.",
        "grains with a known slope of their asperities, in analytical comparisons",
    ),
    "rough-plastic": (
        "Roughness makes the contact soft at low load, as in any rough law. When the bulk yields at the pressure p_y "
        "the stiffness stops growing. A corner that is sharp under the microscope and blunt in a photo has two radii: "
        "roughness acts on R, yield and unloading on `bulk_radius`.",
        "rough contacts at loads that leave visible plastic marks; needs a measured yield pressure",
    ),
    "bahrami": (
        "Gaussian asperities yield plastically while the bulk stays elastic; a compact formula gives the pressure "
        "distribution.",
        "hard rough surfaces of known hardness, as a table",
    ),
    "yip-venart": (
        "A crust of Gaussian asperities yields at the hardness and rests on an elastic half-space; both are solved together.",
        "reference calculations for plastic asperities",
    ),
    "greenwood-tripp": (
        "Elastic Gaussian asperities of equal radius cover the sphere; asperities and the bulk are solved together.",
        "reference calculations for elastic asperities",
    ),
    "asperity": (
        "The measured height map is cut at the overlap. Each patch of contact is an elastic-plastic ellipsoid with "
        "the patch's area and volume.",
        "one pair of surfaces with a measured height map",
    ),
    "thornton-ning": (
        "A smooth sphere is elastic until the pressure in its middle reaches p_y; from there the pressure is limited "
        "and the stiffness is constant. Yielding leaves a flatter surface.",
        "impacts of smooth metal or polymer spheres with a fitted p_y",
    ),
    "jackson-green": (
        "As finite elements have it, a smooth elastic–perfectly plastic sphere becomes softer from first yield to "
        "full plasticity, and its hardness falls as the contact grows.",
        "smooth metal spheres of known yield strength",
    ),
    "kogut-etsion": (
        "Fits of finite elements describe a smooth sphere in three ranges of overlap, from elastic to nearly fully plastic.",
        "smooth metal spheres of known yield strength, up to 110 ω_c",
    ),
    "conical-damage": (
        "A sharp tip crushes as soon as the pressure reaches the strength σ_max, and becomes blunter: its radius "
        "grows with depth.",
        "ballast whose strength and angle were calibrated on bulk tests",
    ),
    "walton-braun": (
        "Two straight lines: loading with k1 and unloading with a larger k2. The difference is the energy loss.",
        "fast simulations with a calibrated coefficient of restitution",
    ),
    "luding": (
        "As Walton and Braun's, with an unloading stiffness that grows with the largest overlap up to a limit.",
        "powders calibrated on bulk tests, without cohesion",
    ),
    "eepa": (
        "A contact that is plastic from the first load, with unloading along a stiffer curve of the same power.",
        "powders and soils calibrated on bulk tests, without adhesion",
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
