"""Errors and warnings that a user of demlaws meets."""


class DemlawsError(ValueError):
    """Bad input: the message names the value, its unit and the remedy."""


class ValidityWarning(UserWarning):
    """A law is used outside the range in which its source supports it."""
