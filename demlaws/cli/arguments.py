"""Kinds of argument that several commands share: quantities with units, whole numbers, names of laws."""

import argparse

from demlaws.errors import DemlawsError


def _quantity(unit, kind):
    def convert(text):
        from demlaws.units import quantity

        try:
            return quantity(text, kind, unit)
        except DemlawsError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return convert


length = _quantity("m", "a length")
pressure = _quantity("Pa", "a pressure")
radius = _quantity("m", "a radius")
force = _quantity("N", "a force")
speed = _quantity("m/s", "a speed")
density = _quantity("kg/m³", "a density")
compliance = _quantity("m/N", "a compliance")
plain = _quantity("", "this")


def whole(low=1, high=10_000_000):
    """A whole number from `low` to `high`; 1e5 is one, too."""

    def convert(text):
        from demlaws import units

        try:
            return units.whole(units.quantity(text, "this"), "this", low, high)
        except DemlawsError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix("this = ")) from None

    return convert
