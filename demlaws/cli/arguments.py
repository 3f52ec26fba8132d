"""Kinds of argument that several commands share: quantities with units, whole numbers, names of laws."""

import argparse
import math

from demlaws.errors import DemlawsError


def _kind(metavar, read):
    """A kind of argument: the function `read` of a text, whose DemlawsError is the option's."""

    def convert(text):
        try:
            return read(text)
        except DemlawsError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix("this = ")) from None

    convert.metavar = metavar
    return convert


def _quantity(unit, kind, metavar):
    def read(text):
        from demlaws.units import quantity

        return quantity(text, kind, unit)

    return _kind(metavar, read)


length = _quantity("m", "a length", "LENGTH")
pressure = _quantity("Pa", "a pressure", "PRESSURE")
force = _quantity("N", "a force", "FORCE")
speed = _quantity("m/s", "a speed", "SPEED")
density = _quantity("kg/m³", "a density", "DENSITY")
compliance = _quantity("m/N", "a compliance", "COMPLIANCE")
plain = _quantity("", "this", "NUMBER")


radius = _kind("LENGTH", lambda text: math.inf if text == "flat" else length(text))
"""A radius in m; "flat" is infinite."""


def whole(low=1, high=10_000_000):
    """A whole number from `low` to `high`; 1e5 is one, too."""

    def read(text):
        from demlaws import units

        return units.whole(units.quantity(text, "this"), "this", low, high)

    return _kind("COUNT", read)
