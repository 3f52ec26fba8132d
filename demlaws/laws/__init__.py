"""One file a law. A new law is a file here and its name in MODULES."""

MODULES = (
    "hertz",
    "pohrt_popov",
)
