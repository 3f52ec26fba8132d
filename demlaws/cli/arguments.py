"""Kinds of argument that several commands share: quantities with units, whole numbers, names of laws."""

import argparse
import re
import sys

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


def in_options(text, arguments):
    """A message of the package with the command's options in place of Python's arguments: --force-noise for force_noise.

    Names in a list, as those of quantities, stay as they are.
    """
    for name in vars(arguments):
        option = f"--{name.replace('_', '-')}"
        text = re.sub(rf"Contact\(\.\.\., {name}=\.\.\.\)", option, text)
        text = re.sub(rf"\b{name}='([\w.-]+)'", rf"{option} \1", text)
        if "_" in name:
            text = re.sub(rf"(?<!, )(?<![-\w]){name}\b(?!,)", option, text)
    return text


def law_name(text):
    """Name of a law; "?" prints all of them."""
    if text == "?":
        from demlaws.cli.laws import print_laws

        print_laws()
        sys.exit(0)
    return text
