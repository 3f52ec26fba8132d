"""The symbols of the equations: meaning and unit. A page lists the symbols of its equation; a test refuses unknown symbols."""

SYMBOLS = {
    "P": ("normal force", "N"),
    "P*": ("force at which the law changes", "N"),
    "K": ("tangent stiffness dP/dδ", "N/m"),
    "δ": ("overlap of the two bodies", "m"),
    "δ_H": ("Hertz overlap at the same force", "m"),
    "R": ("effective radius", "m"),
    "E*": ("effective modulus", "Pa"),
    "σ": ("combined rms roughness", "m"),
    "Df": ("fractal dimension of the surface, 2 to 3", ""),
    "H_m": ("indentation hardness", "Pa"),
    "α": ("roughness over Hertz overlap", ""),
    "a*": ("contact radius of the rough contact", "m"),
    "a_H": ("Hertz contact radius", "m"),
    "a_L'": ("contact radius over Hertz's", ""),
    "p0'": ("pressure in the middle over Hertz's", ""),
    "κ": ("hardness of the asperities over the mean Hertz pressure, as Bahrami et al. define it", ""),
    "A0": ("Hertz contact area at the threshold F: A0 = π R κ σ, κ = (3√π/4) (20/(π^1.5 Df))^(1/(0.2567 Df))", "m²"),
    "F": ("threshold force F = (4/3) E* √R (κ σ)^1.5, above which the stiffness is Hertz's", "N"),
    "β": ("slope of the flank", "rad"),
    "p_y": ("contact pressure at which the bulk yields", "Pa"),
    "K_rough": ("stiffness of the rough law before yield", "N/m"),
    "k1": ("stiffness of first loading", "N/m"),
    "k2": ("stiffness of unloading and reloading", "N/m"),
    "S": ("growth of k2 with the largest force", "1/m"),
    "δp": ("plastic overlap, at which the force vanishes", "m"),
    "δmax": ("largest overlap so far", "m"),
    "Pmax": ("largest force so far", "N"),
    "p0": ("pressure in the middle", "Pa"),
    "δ*": ("overlap at which the stiffness changes", "m"),
    "k\u03022": ("largest stiffness of unloading", "N/m"),
    "σ_max": ("largest pressure that a tip bears before it crushes", "Pa"),
    "R0": ("radius of the tip before it crushed", "m"),
    "A": ("how fast the radius of a crushing tip grows with depth", ""),
    "h": ("elastic part of the overlap", "m"),
    "P_c": ("force at first yield", "N"),
    "ω": ("overlap over that at first yield", ""),
    "ω_c": ("overlap at first yield", "m"),
    "H": ("hardness", "Pa"),
    "H_G": ("hardness of the deformed shape", "Pa"),
    "S_y": ("yield strength", "Pa"),
    "C": ("constant of Poisson's ratio: p0 = C S_y at first yield", ""),
    "R_p": ("radius of curvature after yielding", "m"),
    "s": ("gap of the mean planes over σ", ""),
    "d": ("gap in the middle", ""),
    "r": ("distance from the middle", ""),
    "w": ("displacement of the elastic half-space", ""),
    "p": ("pressure", "Pa"),
    "μ": ("(8/3) η σ √(2R β) with asperity density η and radius β", ""),
    "F_3/2": ("Gaussian integral ∫(t - s)^1.5 φ(t) dt over t > s", ""),
}

COMMON = {"P", "K", "δ", "R", "E*", "σ", "Df", "H_m"}
"""Symbols of most laws, which docs/theory/contact.md explains once."""

OF_LAW = {
    "kogut-etsion": {"K": ("hardness factor: the largest pressure at first yield is K H", "")},
}
"""Law → symbols with another meaning in its paper."""


def meaning(law, symbol):
    """(meaning, unit) of a symbol in a law's equation, or None."""
    return OF_LAW.get(law, {}).get(symbol) or SYMBOLS.get(symbol)
