"""Arrays of contacts: their state, the arrays that results are written to, and threads."""

import itertools
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike

from demlaws.errors import DemlawsError
from demlaws.units import as_float


class State:
    """History of n contacts: one array for each state variable of the unloading rule; all zero before first loading.

    `state.maximum_overlap` is that array; `state.maximum_overlap = saved` sets its values. A state can be copied and
    pickled, to go on later.
    """

    def __init__(self, names, size, dtype=np.float64):
        try:
            if np.ndim(size) or np.dtype(dtype) not in (np.float64, np.float32):  # whole numbers would lose the history
                raise TypeError
            arrays = tuple(np.zeros(size, dtype) for _ in names)
        except (TypeError, ValueError, MemoryError):
            raise DemlawsError(
                f"a state of n = {size!r} contacts in {dtype!r}: give a whole number and float64 or float32"
            ) from None
        self.__dict__.update(names=tuple(names), arrays=arrays)

    def __getattr__(self, name: str) -> np.ndarray:
        # of an object that pickle or copy has not filled yet there is nothing to look up
        names = self.__dict__.get("names", ())
        if name in names:
            return self.arrays[names.index(name)]
        raise AttributeError(f"this state has {', '.join(names) or 'no quantities'}, not {name!r}")

    def __setattr__(self, name: str, values: ArrayLike) -> None:
        if name in ("names", "arrays"):
            raise AttributeError(f"{name} is an array of the state: set its values, do not replace it")
        array = getattr(self, name)
        new = as_float(values, name, array=True)
        if new.shape not in ((), array.shape):
            raise DemlawsError(f"{name} has {array.size} contacts, got values of shape {new.shape}: one entry each")
        array[...] = new

    def __repr__(self):
        return f"demlaws.State({', '.join(f'{n}={a!r}' for n, a in zip(self.names, self.arrays, strict=True))})"

    def copy(self) -> "State":
        """An independent copy."""
        twin = State(self.names, 0)
        twin.__dict__["arrays"] = tuple(array.copy() for array in self.arrays)
        return twin


def writable(out, overlap, state):
    """The two arrays of `out`, or an error where the loop could not write to them or would write over what it reads."""
    try:
        force, stiffness = out
    except (TypeError, ValueError):
        raise DemlawsError(f"out must be two float arrays, for force and stiffness, got {out!r}") from None
    for name, array in (("force", force), ("stiffness", stiffness)):
        if not isinstance(array, np.ndarray) or array.dtype not in (np.float64, np.float32):
            kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
            raise DemlawsError(f"out's {name} must be a float64 or float32 array, got {kind}")
        if not array.flags.writeable:
            raise DemlawsError(f"out's {name} is read-only: give an array that may be written to")
    if force.shape != overlap.shape or stiffness.shape != overlap.shape:
        raise DemlawsError(f"out holds arrays of shape {force.shape} and {stiffness.shape}, overlap has {overlap.shape}")
    every = (overlap, force, stiffness, *state)
    if all(array.base is None for array in every) and len({id(array) for array in every}) == len(every):
        return force, stiffness  # each owns its memory
    read = (("overlap", overlap), *(("the state", array) for array in state))
    for mine, array, others in (("force", force, (*read, ("out's stiffness", stiffness))), ("stiffness", stiffness, read)):
        for name, other in others:
            if np.may_share_memory(array, other) and np.shares_memory(array, other):
                raise DemlawsError(f"out's {mine} shares memory with {name}: give an array of its own")
    return force, stiffness


PIECE = 8192
"""Smallest number of contacts that is worth a thread's turn."""
_pool = _threads = None


def _forget_pool():
    """In a child made by fork the pool's threads do not exist: the next parallel call makes its own."""
    global _pool
    _pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pool)


def in_threads(part, n):
    """Results of part(slice) over all of range(n), in pieces that this thread and those of the pool take in turn."""
    global _pool, _threads
    import numba

    workers = numba.config.NUMBA_NUM_THREADS
    if _pool is None or _threads != workers:
        _pool, _threads = ThreadPoolExecutor(workers), workers
    # several turns a thread: one that the system holds up then keeps the others waiting for a part of its share only
    piece = -(-n // (2 * workers * PIECE)) * PIECE
    numbers = itertools.count()  # next() is one operation for all threads

    def work():
        results = []
        while (start := next(numbers) * piece) < n:
            results.append(part(slice(start, min(start + piece, n))))
        return results

    others = [_pool.submit(work) for _ in range(workers - 1)]
    thread_results = work()
    return [*thread_results, *(result for other in others for result in other.result())]
