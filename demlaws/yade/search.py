"""Where the members of YADE's objects are: found on objects made for this check, proven by writing and reading back.

An object is set to several values through the API, and has their bytes at exactly one place; a value written there reads back
through the API. If one of these does not hold, `BridgeUnavailable` is raised.
"""

import ctypes
import re

import numpy as np
import yade

from demlaws.errors import DemlawsError
from demlaws.yade.records import memory_at

SETTINGS = {
    "f8": (1.2345e33, 2.4691e33, 3.7037e33),
    "i4": (11223344, 55667788, 99001122),
    "i8": (1122334455667788, 2233445566778899, 3344556677889900),
    "u1": (False, True, False, True),
}
"""Format of a number → values that no object has by chance; of a flag."""
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


def find_content(what, cases, step=8):
    """The one byte offset, a multiple of `step`, at which each of these objects has its content: (object, bytes), one after the
    other, so that one object may be changed in between."""
    found = []
    for thing, content in cases:
        memory = read_memory(*window(thing), ctypes.c_uint8).tobytes()
        found.append({place for place in range(0, len(memory), step) if memory.startswith(content, place)})
    places = set.intersection(*found)
    if len(places) != 1:
        raise BridgeUnavailable(f"{what} is not at one place of the object, but at {sorted(places)}")
    return places.pop()


def find_member(thing, name, kind="f8", settings=None, encode=np.array, owner=None):
    """Field of a record, (format, shape of a vector, byte offset): where an object has an attribute, set to each of `settings`.

    owner: whose attribute it is, if not the object's; encode: from the attribute to its number or numbers.
    """
    owner, settings = owner or thing, settings or SETTINGS[kind]

    def content():
        return np.asarray(encode(getattr(owner, name)), kind)

    def cases():
        for setting in settings:
            put(owner, name, setting)
            yield thing, content().tobytes()

    what = f"{type(owner).__name__}.{name}"
    place = find_content(what, cases(), np.dtype(kind).itemsize)
    last = content()
    put(owner, name, settings[0])
    memory_at(window(thing)[0] + place, ctypes.c_uint8 * last.nbytes)[:] = last.tobytes()
    if (content() != last).any():
        raise BridgeUnavailable(f"{what}: what is written at byte {place} does not read back")
    put(owner, name, settings[0])
    return (kind, last.shape, place) if last.shape else (kind, place)


def put(thing, name, value):
    """Set an attribute; some can be set in the second way only."""
    try:
        setattr(thing, name, value)
    except AttributeError:
        thing.updateAttrs({name: value})


def find_vector(thing, name):
    """Field of a Vector3: doubles, x first."""
    return find_member(thing, name, settings=[yade.Vector3(n, 2.0 * n, 3.0 * n) for n in SETTINGS["f8"]])


def find_pointer(cls, name, target_cls):
    """Field of a shared pointer: the target's address."""

    def cases():
        for _ in range(3):
            thing = cls()
            setattr(thing, name, target_cls())
            yield thing, address_bytes(getattr(thing, name))

    return "i8", find_content(f"{cls.__name__}.{name}", cases())


def find_word(thing, target):
    """Field of an object that has the address of another one."""
    return "i8", find_content(f"address of {type(target).__name__} in {type(thing).__name__}", [(thing, address_bytes(target))])


def address_bytes(thing):
    """The address of an object as it is in memory."""
    return address(thing).to_bytes(8, "little")


def find_string(cls, name):
    """Byte offset of a std::string: a pointer to the characters within the object, their number, the characters."""
    things = [cls(**{name: text}) for text in ("abcdefgh", "ijklmno", "pqrstu")]
    texts = [getattr(thing, name).encode() for thing in things]
    cases = [(thing, len(text).to_bytes(8, "little") + text) for thing, text in zip(things, texts, strict=True)]
    place = find_content(f"{cls.__name__}.{name}", cases) - 8
    for thing in things:
        if memory_at(address(thing) + place).value != address(thing) + place + 16:
            raise BridgeUnavailable(f"{cls.__name__}.{name} does not point to characters within the object")
    return place


def columns(matrix):
    """A Matrix3 as it is in memory, column by column."""
    return np.array([[matrix[row, column] for row in range(3)] for column in range(3)]).tobytes()


def find_shift_velocity():
    """Byte offset in Cell of velGrad times prevHSize, column by column: velocity [m/s] of a neighbouring cell per cell."""

    def cases():
        for value in (1.5, 2.5, 3.5):  # products without rounding
            cell = yade.Cell()
            cell.hSize = yade.Matrix3(value, 0.25, 0.5, 0.75, 2, 0.5, 0.125, 0.375, 3)
            cell.updateAttrs({"velGrad": yade.Matrix3(5, value, 7, 1, 2, 3, 4, value, 9)})
            yield cell, columns(cell.velGrad * cell.prevHSize)

    return find_content("velGrad * prevHSize of Cell", cases())


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
