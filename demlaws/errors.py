"""Errors and warnings that a user of demlaws meets."""


class DemlawsError(ValueError):
    """Bad input: the message names the value, its unit and the remedy."""


class NotPassive(DemlawsError):
    """A law and an unloading rule that together would return more work than loading took."""


class NeedsClasses(DemlawsError):
    """A curve that depends on the radius, asked for a range of radii: it needs grains of a few sizes."""


class ValidityWarning(UserWarning):
    """A law is used outside the range in which its source supports it."""


class LargeOverlap(ValidityWarning):
    """An overlap beyond a tenth of the effective radius."""
