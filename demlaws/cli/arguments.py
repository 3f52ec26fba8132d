"""Kinds of argument that several commands share: quantities with units, whole numbers, names of laws."""

import argparse
import math

from demlaws.errors import DemlawsError


def _quantity(unit, kind, metavar):
    def convert(text):
        from demlaws.units import quantity

        try:
            return quantity(text, kind, unit)
        except DemlawsError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    convert.metavar = metavar
    return convert


length = _quantity("m", "a length", "LENGTH")
pressure = _quantity("Pa", "a pressure", "PRESSURE")
force = _quantity("N", "a force", "FORCE")
speed = _quantity("m/s", "a speed", "SPEED")
density = _quantity("kg/m³", "a density", "DENSITY")
compliance = _quantity("m/N", "a compliance", "COMPLIANCE")
plain = _quantity("", "this", "NUMBER")


def radius(text):
    """A radius in m; "flat" is infinite."""
    return math.inf if text == "flat" else length(text)


radius.__dict__["metavar"] = "LENGTH"


def whole(low=1, high=10_000_000):
    """A whole number from `low` to `high`; 1e5 is one, too."""

    def convert(text):
        from demlaws import units

        try:
            return units.whole(units.quantity(text, "this"), "this", low, high)
        except DemlawsError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix("this = ")) from None

    convert.metavar = "COUNT"
    return convert
