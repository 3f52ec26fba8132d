"""Errors and warnings that a user of demlaws meets."""


class DemlawsError(ValueError):
    """Bad input: the message names the value, its unit and the remedy.

    >>> dl.Contact(radius=-1e-3, modulus=32e9)
    Traceback (most recent call last):
    demlaws.errors.DemlawsError: radius = -0.001 m: the effective radius must be positive (two flats have no Hertz contact)
    """


class NotPassive(DemlawsError):
    """A law and an unloading rule that together would return more work than loading took."""


class EngineStopped(DemlawsError):
    """An engine has read an input and ended with an error of its own."""


class NeedsClasses(DemlawsError):
    """A curve that depends on the radius, asked for a range of radii: it needs grains of a few sizes."""


class ValidityWarning(UserWarning):
    """A law is used outside the range in which its source supports it.

    >>> import warnings
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9, hardness=6e9))
    >>> with warnings.catch_warnings(record=True) as said:
    ...     warnings.simplefilter("always")
    ...     force = law.force(1e-3)  # m: the bulk would have yielded
    >>> any(one.category is dl.ValidityWarning for one in said)
    True
    """


class LargeOverlap(ValidityWarning):
    """An overlap beyond a tenth of the effective radius."""
