"""What `make trade` measured and `choose` and `modulus` need of it, in one small file."""

import functools
import json
from pathlib import Path

FILE = Path(__file__).with_name("measured_costs.json")
"""Written by `python -m studies.trade --keep`: costs in ns per contact, errors of softened packings as curves."""


@functools.cache
def measured_costs():
    """The content of `FILE`."""
    return json.loads(FILE.read_text(encoding="utf-8"))
