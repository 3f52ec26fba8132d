"""Where the members of YADE's objects are: found on objects made for this check, proven by writing and reading back.

A number written through the API is found at exactly one place of three objects, is written there, and reads back through the
API. If one of these does not hold, `BridgeUnavailable` is raised.
"""

import ctypes
import re

import numpy as np
import yade

from demlaws.errors import DemlawsError
from demlaws.yade.records import memory_at

NUMBERS = (11223344, 55667788, 99001122)
"""Integers that no object has by chance."""
LARGEST_OBJECT = 4096  # bytes; a larger block was not allocated by malloc


class BridgeUnavailable(DemlawsError):
    """An assumption of the native bridge does not hold here; nothing was patched."""


_native_repr = yade.Serializable.__repr__


def address(thing):
    """Address of the C++ object behind a YADE Python object: the wrapper shows it in its repr."""
    text = _native_repr(thing)
    match = re.search(r" instance at 0x([0-9a-fA-F]+)>", text)
    if match is None:
        raise BridgeUnavailable(f"no address in {text}")
    return int(match.group(1), 16)


_libc = ctypes.CDLL(None)
_libc.malloc_usable_size.restype = ctypes.c_size_t
_libc.malloc_usable_size.argtypes = [ctypes.c_void_p]


def window(thing):
    """Address and size [bytes] of an object's own memory, so that nothing beyond it is read."""
    start = address(thing)
    size = _libc.malloc_usable_size(start)
    if start % 16 or not 16 <= size <= LARGEST_OBJECT:
        raise BridgeUnavailable(f"{thing!r} is not the start of a block of memory of its own")
    return start, size


def read_memory(start, size, kind):
    """`size` bytes of this process from address `start`, as an array of a ctypes kind, not copied."""
    return np.ctypeslib.as_array(memory_at(start, kind * (size // ctypes.sizeof(kind))))


def _only(places, what):
    """The one offset [bytes] of `places`."""
    if len(places) != 1:
        raise BridgeUnavailable(f"{what} is not at one place of the object, but at {sorted(map(int, places))}")
    return int(next(iter(places)))


def one_place(cls, name, things, matches):
    """The byte offset at which `matches(start, size, thing)` finds an attribute in each of these objects."""
    places = (set(map(int, matches(*window(thing), thing))) for thing in things)
    return _only(set.intersection(*places), f"{cls.__name__}.{name}")


def find_number(cls, name, kind=ctypes.c_double, values=(1.2345e33, 2.4691e33, 3.7037e33), make=None, read=None):
    """Byte offset of a number: where `values` are found in three objects; a number written there reads back."""
    things = [make(value) if make else cls(**{name: value}) for value in values]
    value_of = {id(thing): value for thing, value in zip(things, values, strict=True)}

    def matches(start, size, thing):
        return np.flatnonzero(read_memory(start, size, kind) == value_of[id(thing)]) * ctypes.sizeof(kind)

    place = one_place(cls, name, things, matches)
    memory_at(window(things[-1])[0] + place, kind).value = values[0]
    if (read(things[-1]) if read else getattr(things[-1], name)) != values[0]:
        raise BridgeUnavailable(f"{cls.__name__}.{name}: a number written at byte {place} does not read back")
    return place


def find_flag(thing, name, owner=None):
    """Byte of `thing` that is 1 while this attribute of `owner` (default: `thing`) is set, and else 0."""
    seen, owner = [], owner or thing
    for value in (False, True, False):
        setattr(owner, name, value)
        seen.append(read_memory(*window(thing), ctypes.c_uint8).copy())
    return _only(np.flatnonzero((seen[0] == 0) & (seen[1] == 1) & (seen[2] == 0)), f"the flag {type(owner).__name__}.{name}")


def find_string(cls, name):
    """Byte offset of a std::string: a pointer to the characters within the object, their number, the characters."""

    def matches(start, size, thing):
        text = getattr(thing, name).encode()
        words = read_memory(start, size, ctypes.c_uint64)
        here = start + 8 * np.arange(words.size)
        candidates = 8 * np.flatnonzero((words[:-1] == here[:-1] + 16) & (words[1:] == len(text)))
        return [n for n in candidates.tolist() if memory_at(start + n + 16, ctypes.c_char * len(text)).raw == text]

    return one_place(cls, name, [cls(**{name: text}) for text in ("abcdefgh", "ijklmno", "pqrstu")], matches)


def find_pointer(cls, name, target_cls):
    """Byte offset of a shared_ptr attribute: where the target's address is."""

    def matches(start, size, thing):
        return 8 * np.flatnonzero(read_memory(start, size, ctypes.c_uint64) == address(getattr(thing, name)))

    owners = [cls() for _ in range(3)]
    for owner in owners:
        setattr(owner, name, target_cls())
    return one_place(cls, name, owners, matches)


def _mappings():
    """(first address, address behind the last, mode, path) of each mapping of this process."""
    with open("/proc/self/maps") as maps:
        for line in maps:
            span, mode, *rest = line.split(maxsplit=5)
            low, high = (int(text, 16) for text in span.split("-"))
            yield low, high, mode, rest[-1].strip()


def mapped(file_end):
    """Path of the loaded library whose name ends so."""
    paths = {path for *_, path in _mappings() if path.endswith(file_end)}
    if len(paths) != 1:
        raise BridgeUnavailable(
            f"{len(paths)} loaded libraries are named {file_end[1:]}, not one: the bridge needs the shared libraries "
            "libyade.so, libpkg_dem.so and libpre_dem.so, of YADE 2022.01a or newer (up to 2021 YADE is one library)"
        )
    return paths.pop()


def mapped_until(location):
    """End of the readable mapping that contains `location`."""
    for low, high, mode, _ in _mappings():
        if low <= location < high and mode[0] == "r":
            return high
    raise BridgeUnavailable(f"nothing readable at {location:#x}")


class _SymbolInformation(ctypes.Structure):
    _fields_ = [
        ("file", ctypes.c_char_p),
        ("base", ctypes.c_void_p),
        ("symbol", ctypes.c_char_p),
        ("location", ctypes.c_void_p),
    ]


def symbol_at(location):
    """Name of the exported symbol that begins at `location`, or None."""
    information = _SymbolInformation()
    if not _libc.dladdr(ctypes.c_void_p(location), ctypes.byref(information)) or information.location != location:
        return None
    return information.symbol.decode()


def symbol(library, name):
    """Address of an exported symbol."""
    try:
        return ctypes.cast(getattr(library, name), ctypes.c_void_p).value
    except AttributeError:
        raise BridgeUnavailable(f"YADE's libraries do not export {name}") from None


def find_vector(cls, name, count=3):
    """Byte offset of a Vector3, or of a Quaternion (count 4): doubles, x first."""

    def make(value):
        thing = cls()
        vector = yade.Vector3(value, 2.0, 3.0) if count == 3 else yade.Quaternion(0.5, value, 0.25, 0.125)
        if cls is yade.State and name in ("pos", "ori"):  # no arguments of State
            setattr(thing, name, vector)
        else:  # shearInc cannot be set otherwise
            thing.updateAttrs({name: vector})
        return thing

    # as small as parts of a unit quaternion
    values = (0.1234567, 0.2345678, 0.3456789)
    place = find_number(cls, name, values=values, make=make, read=lambda thing: getattr(thing, name)[0])
    thing = make(0.5)
    expected = [getattr(thing, name)[n] for n in range(count)]
    if list(read_memory(address(thing) + place, 8 * count, ctypes.c_double)) != expected:
        raise BridgeUnavailable(f"{cls.__name__}.{name} is not {count} doubles in the expected order")
    return place


def find_word(thing, target):
    """Byte offset of the 8 bytes of an object that has the address of another one."""
    places = 8 * np.flatnonzero(read_memory(*window(thing), ctypes.c_uint64) == address(target))
    return _only(places, f"the address of {type(target).__name__} in {type(thing).__name__}")


def type_of(cls):
    """Address of a class's type, which is before the table of virtual functions with which its objects begin.

    With link-time optimisation each library may have a table of its own; the type is one.
    """
    thing = cls()  # referenced while it is read
    first = memory_at(window(thing)[0]).value
    mapped_until(first - 8)
    found, name = memory_at(first - 8).value, f"_ZTIN4yade{len(cls.__name__)}{cls.__name__}E"
    if symbol_at(found) != name:
        raise BridgeUnavailable(f"{cls.__name__} does not begin with a table of virtual functions of its type {name}")
    return found


def _places_of_matrix(start, size, matrix):
    """Byte offsets at which an object has the numbers of a Matrix3, column by column."""
    expected = [matrix[row, column] for column in range(3) for row in range(3)]
    numbers = np.lib.stride_tricks.sliding_window_view(read_memory(start, size, ctypes.c_double), 9)
    return 8 * np.flatnonzero(np.isclose(numbers, expected, rtol=1e-14, atol=0.0).all(axis=1))


def find_shift_velocity():
    """Byte offset in Cell of velGrad times prevHSize, column by column: velocity [m/s] of a neighbouring cell per cell."""

    def make(value):
        cell = yade.Cell()
        cell.hSize = yade.Matrix3(value, 0.1, 0.2, 0.3, 2, 0.5, 0.1, 0.7, 3)
        cell.updateAttrs({"velGrad": yade.Matrix3(5, value, 7, 1, 2, 3, 4, value, 9)})
        return cell

    def matches(start, size, cell):
        return _places_of_matrix(start, size, cell.velGrad * cell.prevHSize)

    return one_place(yade.Cell, "velGrad * prevHSize", [make(value) for value in (1.5, 2.5, 3.5)], matches)


def find_scene_number(scene, name, values=(1.25e-7, 2.5e-7, 3.125e-7)):
    """Byte offset in the current scene of a number that is an attribute of O."""

    def matches(start, size, value):
        setattr(yade.O, name, value)
        return 8 * np.flatnonzero(read_memory(start, size, ctypes.c_double) == value)

    return _only(set.intersection(*(set(matches(*window(scene), value).tolist()) for value in values)), f"O.{name}")


def find_degrees_of_freedom():
    """Byte offset in State of blockedDOFs: an unsigned integer of one bit for each of xyzXYZ."""
    names = {9: "xX", 34: "yZ", 44: "zXZ"}

    def make(value):
        state = yade.State()
        state.blockedDOFs = names[value]
        return state

    values, bits = tuple(names), {name: value for value, name in names.items()}
    return find_number(yade.State, "blockedDOFs", ctypes.c_uint32, values, make, lambda state: bits.get(state.blockedDOFs))


def find_cell_distance():
    """Byte offset in Interaction of cellDist: how many cells its bodies are apart."""

    def make(cells):
        contact = yade.Interaction()
        contact.updateAttrs({"cellDist": yade.Vector3i(cells, 7, -5)})
        return contact

    return find_number(yade.Interaction, "cellDist", ctypes.c_int32, NUMBERS, make, lambda contact: contact.cellDist[0])


def find_cell_size(cell):
    """Byte offset in Cell of hSize, column by column; `cell` has moved, so that it differs from former sizes."""
    return _only(_places_of_matrix(*window(cell), cell.hSize), "Cell.hSize")


def _turned(v, axes):
    """A vector as ScGeom::rotate turns it, by the change of the normal and then about it."""
    for axis in axes:
        v = v - np.cross(v, axis)
    return v


def find_axes(rotate):
    """Byte offsets in ScGeom of the two axes by which ScGeom::rotate, at this address, turns a vector v: to v - v × axis, first
    by the one and then by the other.

    They are no attributes: they are where a change of memory changes what rotate does.
    """
    call = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(rotate)
    geom = yade.ScGeom()
    start, size = window(geom)
    memory = read_memory(start, size, ctypes.c_double)
    kept, vectors = memory.copy(), np.random.default_rng(1).uniform(-1.0, 1.0, (3, 3))

    def turned(vector):
        place = vector.copy()
        call(start, place.ctypes.data)
        return place

    try:
        memory[1:] = 0.0
        acting = []
        for n in range(1, memory.size):
            memory[n] = 0.5
            acting += [n] if any((turned(vector) != vector).any() for vector in vectors) else []
            memory[n] = 0.0
        memory[acting] = np.random.default_rng(2).uniform(-1.0, 1.0, len(acting))
        places = (acting[0], acting[3]) if len(acting) == 6 else (1, 1)
        for first, second in (places, places[::-1]):
            axes = memory[first : first + 3], memory[second : second + 3]
            if all(np.allclose(turned(vector), _turned(vector, axes), rtol=0.0, atol=1e-14) for vector in vectors):
                return 8 * first, 8 * second
    finally:
        memory[:] = kept
    raise BridgeUnavailable(f"ScGeom::rotate does not turn vectors by two axes, but by the words {acting}")
