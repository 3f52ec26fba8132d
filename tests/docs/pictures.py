"""Whether two pictures show the same, fonts and anti-aliasing aside."""

import numpy as np

COARSE, LARGEST = 12, 0.06
"""Pixels per side of a block; largest difference of the means of two blocks, as a share of white, that fonts may cause."""


def blocks(path):
    """Means of blocks of a picture, grey from 0 to 1."""
    from matplotlib.image import imread

    grey = imread(path)[..., :3].mean(axis=2)
    rows, columns = (n // COARSE * COARSE for n in grey.shape)
    return grey[:rows, :columns].reshape(rows // COARSE, COARSE, columns // COARSE, COARSE).mean(axis=(1, 3))


def difference(first, second):
    """Share of blocks that differ visibly; 1 for pictures of different sizes."""
    one, other = blocks(first), blocks(second)
    if one.shape != other.shape:
        return 1.0
    return float(np.mean(np.abs(one - other) > LARGEST))
