"""Extended precision (numpy.longdouble) for the laws' own references: equations written out, no compiled kernel."""

import numpy as np

L = np.longdouble
PI = L("3.14159265358979323846264338327950288")


def extended(value):
    """A number, an array or a decimal text in extended precision."""
    return L(value) if isinstance(value, str) else np.asarray(value, L)


def from_hertz(contact, equivalent, slope):
    """Force P = (4/3) E* √R s^1.5 [N] and stiffness [N/m] of a Hertz-equivalent overlap s [m] with ds/dδ = `slope`."""
    root = 4 * extended(contact.modulus) * np.sqrt(extended(contact.radius)) / 3 * np.sqrt(equivalent)
    return root * equivalent, 3 * root * slope / 2
