"""One file per law. A new law is a file here and its name in MODULES."""

MODULES = (
    "hertz",
    "rms",
    "pohrt_popov",
    "goddard",
    "rough_plastic",
    "bahrami",
    "yip_venart",
    "greenwood_tripp",
    "asperity",
    "thornton_ning",
    "jackson_green",
    "kogut_etsion",
    "conical_damage",
    "walton_braun",
    "luding",
    "eepa",
)

# Names of laws for code outside this folder: a misspelt one is an error on import, not in a run.
HERTZ, RMS, POHRT_POPOV, GODDARD = "hertz", "rms", "pohrt-popov", "goddard"
YIP_VENART, BAHRAMI, GREENWOOD_TRIPP, ROUGH_PLASTIC = "yip-venart", "bahrami", "greenwood-tripp", "rough-plastic"
ASPERITY, THORNTON_NING, CONICAL_DAMAGE = "asperity", "thornton-ning", "conical-damage"
JACKSON_GREEN, KOGUT_ETSION = "jackson-green", "kogut-etsion"
WALTON_BRAUN, LUDING, EEPA = "walton-braun", "luding", "eepa"

USUAL = POHRT_POPOV
"""Default law of commands and exports."""
