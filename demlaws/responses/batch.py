"""Arrays of contacts: their state, the arrays that results are written to, and threads."""

import copy
import functools
import operator
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike

from demlaws.errors import DemlawsError
from demlaws.units import as_float, number


class State:
    """History of n contacts: one array for each state variable of the unloading rule; all zero before first loading.

    `state.maximum_overlap` is that array; `state.maximum_overlap = saved` sets its values. A state can be copied and
    pickled, to go on later. `state.banked` is what a contact followed by `Law.follow` has dissipated before it last opened [J].
    """

    names: tuple
    arrays: tuple
    banked: float

    def __init__(self, names, size, dtype=np.float64):
        try:
            if operator.index(size) < 0 or np.dtype(dtype) not in (np.float64, np.float32):  # whole numbers lose the history
                raise TypeError
            arrays = tuple(np.zeros(size, dtype) for _ in names)
        except MemoryError:
            raise DemlawsError(f"not enough memory for a state of n = {size!r:.60} contacts") from None
        except (TypeError, ValueError):
            raise DemlawsError(
                f"a state of n = {size!r:.60} contacts in {dtype!r:.60}: give a whole number and float64 or float32"
            ) from None
        self.__dict__.update(names=tuple(names), arrays=arrays, banked=0.0)

    def __getattr__(self, name: str) -> np.ndarray:
        # of an object that pickle or copy has not filled yet there is nothing to look up
        names = self.__dict__.get("names", ())
        if name in names:
            return self.arrays[names.index(name)]
        raise AttributeError(f"this state has {', '.join(names) or 'no quantities'}, not {name!r}")

    def __setattr__(self, name: str, values: ArrayLike) -> None:
        if name == "banked":
            self.__dict__[name] = number(values, name, "J", allow_low=True)
            return
        getattr(self, name)[...] = as_float(values, name, array=True)

    def __repr__(self):
        return f"demlaws.State({', '.join(f'{n}={a!r}' for n, a in zip(self.names, self.arrays, strict=True))})"

    def copy(self) -> "State":
        """An independent copy."""
        return copy.deepcopy(self)


def writable(out, overlap, state):
    """The two arrays of `out`, or an error where the loop could not write to them or would write over what it reads."""
    try:
        force, stiffness = out
        fit = [a.shape == overlap.shape and a.flags.writeable and a.dtype in (np.float64, np.float32) for a in out]
    except (TypeError, ValueError, AttributeError):
        fit = [False]
    if not all(fit):
        raise DemlawsError(
            f"out must be two writable float64 or float32 arrays of shape {overlap.shape}, for force and stiffness"
        )
    for array, others in ((force, (stiffness, overlap, *state)), (stiffness, (overlap, *state))):
        if any(np.may_share_memory(array, other) and np.shares_memory(array, other) for other in others):
            raise DemlawsError("out shares memory with the overlaps, the state or itself: give arrays of their own")
    return force, stiffness


PIECE = 8192
"""Smallest number of contacts that is worth a thread's turn."""


@functools.cache
def _pool(workers):
    return ThreadPoolExecutor(workers)


os.register_at_fork(after_in_child=_pool.cache_clear)  # in a child made by fork the pool's threads do not exist


def in_threads(part, n):
    """Results of part(slice) over all of range(n), in pieces that the threads of the pool take in turn."""
    import numba

    workers = numba.config.NUMBA_NUM_THREADS
    # several turns a thread: one that the system holds up then keeps the others waiting for a part of its share only
    piece = -(-n // (2 * workers * PIECE)) * PIECE
    return list(_pool(workers).map(part, (slice(start, start + piece) for start in range(0, n, piece))))
