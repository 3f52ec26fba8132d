"""Options of earlier versions: refused, with what to write now."""

import argparse

from demlaws.errors import DemlawsError


class Refused(argparse.Action):
    """An option that is no more; `remedy` says what to give in its place. It does not show in the help."""

    def __init__(self, option_strings, dest, remedy, **options):
        super().__init__(option_strings, dest, nargs="*", default=argparse.SUPPRESS, help=argparse.SUPPRESS, **options)
        self.remedy = remedy

    def __call__(self, parser, namespace, values, option_string=None):
        raise DemlawsError(f"{option_string} is no option any more, since it meant two things: {self.remedy}")
