"""One file a law. A new law is a file here and its name in MODULES."""

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
