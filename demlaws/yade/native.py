"""The native bridge: our law as the `go` of a native Law2_ScGeom_MindlinPhys_Mindlin. All that depends on YADE's binary.

YADE is C++; Debian ships no headers, and YADE never calls the `go` of a Python subclass. So a functor object gets a private
copy of its table of virtual functions, with `go` replaced by compiled code (`kernel.act`) that writes our force as Mindlin's
coefficients kno and kso and then applies Mindlin's law, by itself or by calling the native `go`. Every other functor keeps the
original table, and the rest of YADE's memory is unchanged.

All assumptions are checked here: against exported symbols, against the layout rules of the Itanium C++ ABI, and on objects
made for this check (a number written through the API is found at exactly one place of three objects, is written there, and
reads back through the API). If one does not hold, `BridgeUnavailable` is raised and nothing has been patched.

A preloaded shared object that interposes `go` is no faster, needs a compiler or a binary and a launcher, and acts on every
Mindlin functor of the process. It would survive `O.load`; here a guard attaches the law again.
"""

import ctypes
import mmap
import os
import re

import numpy as np
import yade
import yade.config

from demlaws.errors import DemlawsError
from demlaws.yade import kernel
from demlaws.yade import layout as at

TESTED = ("2023.02a", "2025.2.0", "2026.1.0")
"""Versions on which the tests have run; the checks below decide for every other one."""
LAW = "Law2_ScGeom_MindlinPhys_Mindlin"
GO = f"_ZN4yade{len(LAW)}{LAW}2goERN5boost10shared_ptrINS_5IGeomEEERNS2_INS_5IPhysEEEPNS_11InteractionE"
TABLE = f"_ZTVN4yade{len(LAW)}{LAW}E"
BODY_BY_ID = "_ZN4yade4Body4byIdEiPNS_5SceneE"
VECTOR = "RKN5Eigen6MatrixIdLi3ELi1ELi0ELi3ELi1EEE"
ROTATE = f"_ZNK4yade6ScGeom6rotateE{VECTOR.replace('K', '', 1)}"
APPLY = f"_ZN4yade10LawFunctor24applyForceAtContactPointE{VECTOR}S5_iS5_iS5_"
OPTIONS = ("includeAdhesion", "calcEnergy", "includeMoment", "neverErase")
"""Options of Mindlin's law with which `shear.step_alone` is not used."""
DAMPING_KINDS = ("alpha", "beta")
"""Names that MindlinPhys had for the exponent of viscous damping."""
NOT_TRIED = "not tried"
SINGLE_BASE = "_ZTVN10__cxxabiv120__si_class_type_infoE"
ROUND_SHAPES = ("Sphere", "GridNode", "GridConnection", "PFacet", "ChainedCylinder")
"""Shapes with a radius of their own, where YADE has them."""
LARGEST_OBJECT = 4096  # bytes; a larger block was not allocated by malloc
FURTHER_GEOMETRIES = ("ScGridCoGeom", "CylScGeom", "CylScGeom6D", "ChCylGeom6D")
"""Classes derived from ScGeom, by which spheres touch grids, facets between grid nodes, and chained cylinders."""
PLACES_IN_GEOMETRY = (("penetrationDepth", at.OVERLAP), ("refR1", at.RADIUS1), ("refR2", at.RADIUS2))
PLACES_IN_PHYSICS = (("kn", at.KN), ("kno", at.KNO), ("kso", at.KSO))
MOST_ROWS = 2**23
"""Contacts that a law can act on at a time: the address space of their rows is reserved, memory is used as they are made."""
FEW_ROWS = 1024
"""Rows beside twice those in use that are made before rows are looked for that may be used again."""
COPIED = 64  # words of a virtual table that are copied; Mindlin's has 8

MAP_NORESERVE = 0x4000  # of Linux; Python 3.11 has no name for it

_forever = []  # never freed, since native code may still point there


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


def _window(thing):
    """Address and size [bytes] of an object's own memory, so that nothing beyond it is read."""
    start = address(thing)
    size = _libc.malloc_usable_size(start)
    if start % 16 or not 16 <= size <= LARGEST_OBJECT:
        raise BridgeUnavailable(f"{thing!r} is not the start of a block of memory of its own")
    return start, size


def read_memory(start, size, kind):
    """`size` bytes of this process from address `start`, as an array of a ctypes kind, not copied."""
    return np.ctypeslib.as_array((kind * (size // ctypes.sizeof(kind))).from_address(start))


def _one_place(cls, name, things, matches):
    """The byte offset at which `matches(start, size, thing)` finds an attribute in each of these objects."""
    places = None
    for thing in things:
        here = {int(place) for place in matches(*_window(thing), thing)}
        places = here if places is None else places & here
    if len(places) != 1:
        raise BridgeUnavailable(f"{cls.__name__}.{name} is not at one place of the object, but at {sorted(places)}")
    return places.pop()


def _find(cls, name, kind=ctypes.c_double, values=(1.2345e33, 2.4691e33, 3.7037e33), make=None, read=None):
    """Byte offset of a number: where `values` are found in three objects; a number written there reads back."""
    things = [make(value) if make else cls(**{name: value}) for value in values]
    value_of = {id(thing): value for thing, value in zip(things, values, strict=True)}

    def matches(start, size, thing):
        return np.flatnonzero(read_memory(start, size, kind) == value_of[id(thing)]) * ctypes.sizeof(kind)

    place = _one_place(cls, name, things, matches)
    kind.from_address(_window(things[-1])[0] + place).value = values[0]
    if (read(things[-1]) if read else getattr(things[-1], name)) != values[0]:
        raise BridgeUnavailable(f"{cls.__name__}.{name}: a number written at byte {place} does not read back")
    return place


def _find_flag(thing, name, owner=None):
    """Byte of `thing` that is 1 while this attribute of `owner` (default: `thing`) is set, and else 0."""
    seen, owner = [], owner or thing
    for value in (False, True, False):
        setattr(owner, name, value)
        seen.append(read_memory(*_window(thing), ctypes.c_uint8).copy())
    places = np.flatnonzero((seen[0] == 0) & (seen[1] == 1) & (seen[2] == 0))
    if len(places) != 1:
        raise BridgeUnavailable(f"{type(owner).__name__}.{name} is not one byte, but at {places.tolist()}")
    return int(places[0])


def _find_string(cls, name):
    """Byte offset of a std::string: a pointer to the characters within the object, their number, the characters."""

    def matches(start, size, thing):
        text = getattr(thing, name).encode()
        words = read_memory(start, size, ctypes.c_uint64)
        here = start + 8 * np.arange(words.size)
        candidates = 8 * np.flatnonzero((words[:-1] == here[:-1] + 16) & (words[1:] == len(text)))
        return [n for n in candidates.tolist() if ctypes.string_at(start + n + 16, len(text)) == text]

    return _one_place(cls, name, [cls(**{name: text}) for text in ("abcdefgh", "ijklmno", "pqrstu")], matches)


def _find_pointer(cls, name, target_cls):
    """Byte offset of a shared_ptr attribute: where the target's address is."""

    def matches(start, size, thing):
        return 8 * np.flatnonzero(read_memory(start, size, ctypes.c_uint64) == address(getattr(thing, name)))

    owners = [cls() for _ in range(3)]
    for owner in owners:
        setattr(owner, name, target_cls())
    return _one_place(cls, name, owners, matches)


def _mappings():
    """(first address, address behind the last, mode, path) of each mapping of this process."""
    with open("/proc/self/maps") as maps:
        for line in maps:
            span, mode, *rest = line.split(maxsplit=5)
            low, high = (int(text, 16) for text in span.split("-"))
            yield low, high, mode, rest[-1].strip()


def _mapped(file_end):
    """Path of the loaded library whose name ends so."""
    paths = {path for *_, path in _mappings() if path.endswith(file_end)}
    if len(paths) != 1:
        raise BridgeUnavailable(f"{len(paths)} loaded libraries are named {file_end}, not one")
    return paths.pop()


def _mapped_until(location):
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


def _symbol_at(location):
    """Name of the exported symbol that begins at `location`, or None."""
    information = _SymbolInformation()
    if not _libc.dladdr(ctypes.c_void_p(location), ctypes.byref(information)) or information.location != location:
        return None
    return information.symbol.decode()


class Layout:
    """Addresses and offsets in this process's YADE, found and verified once."""

    def __init__(self):
        self.version = yade.config.version
        if getattr(yade.config, "highPrecisionBits", 64) != 64:  # its suffix is whatever it was built with
            raise BridgeUnavailable(f"this YADE computes in {yade.config.highPrecisionName}; the bridge needs double")
        if ctypes.sizeof(ctypes.c_void_p) != 8:
            raise BridgeUnavailable("the bridge needs a 64-bit machine")
        self.library = ctypes.CDLL(_mapped("/libpkg_dem.so"))
        self.core = ctypes.CDLL(_mapped("/libyade.so"))
        self.table = self._symbol(self.library, TABLE)
        self.table_end = _mapped_until(self.table)
        self.body_by_id = self._symbol(self.core, BODY_BY_ID)
        self.offsets = {
            at.OVERLAP: _find(yade.ScGeom, "penetrationDepth"),
            at.RADIUS1: _find(yade.ScGeom, "refR1"),
            at.RADIUS2: _find(yade.ScGeom, "refR2"),
            at.KN: _find(yade.MindlinPhys, "kn"),
            at.KNO: _find(yade.MindlinPhys, "kno"),
            at.KSO: _find(yade.MindlinPhys, "kso"),
            at.MARK: self._vector("prevU") + 8,
            at.SHEAR_FORCE: self._vector("shearElastic"),
            at.NORMAL_FORCE: self._vector("normalForce"),
            at.DISPLACEMENT: self._vector("usTotal"),
            at.STRETCH: self._vector("usElastic"),
            at.FRICTION: _find(yade.MindlinPhys, "tangensOfFrictionAngle"),
            at.NORMAL: self._vector("normal", yade.ScGeom),
            at.BODY1: self._body_number("id1"),
            at.BODY2: self._body_number("id2"),
            at.MATERIAL: _find_pointer(yade.Body, "material", yade.FrictMat),
            at.LABEL: _find_string(yade.FrictMat, "label"),
            at.SHAPE: _find_pointer(yade.Body, "shape", yade.Sphere),
            at.BODY_STATE: _find_pointer(yade.Body, "state", yade.State),
            at.POSITION: self._vector("pos", yade.State),
            at.ORIENTATION: self._quaternion(),
            at.POINT: self._vector("contactPoint", yade.ScGeom),
            at.INCREMENT: self._vector("shearInc", yade.ScGeom),
            at.BETAS: _find(yade.MindlinPhys, "betas"),
            at.ROTATE: self._symbol(self.library, ROTATE),
        }
        self.number_done = _find(yade.PyRunner, "nDone", ctypes.c_int64, (1122334455667788, 2233445566778899, 3344556677889900))
        self.classes = {
            word: self._first_word(cls)
            for word, cls in (
                (at.GEOMETRY, yade.ScGeom),
                (at.GEOMETRY_6D, yade.ScGeom6D),
                (at.PHYSICS, yade.MindlinPhys),
                (at.FACET, yade.Facet),
                (at.WALL, yade.Wall),
                (at.BOX, yade.Box),
            )
        }
        self._same_places(yade.ScGeom6D, yade.ScGeom)
        further = [getattr(yade, name) for name in FURTHER_GEOMETRIES if hasattr(yade, name)]
        for n, cls in enumerate(further):
            self._same_places(cls, yade.ScGeom)
            self.classes[at.GEOMETRIES + n] = self._first_word(cls)
        for n, name in enumerate(name for name in ROUND_SHAPES if hasattr(yade, name)):
            self.classes[at.ROUND_SHAPES + n] = self._first_word(getattr(yade, name))
        self.classes[at.PHYSICS_CAPILLARY] = self.classes[at.PHYSICS]
        if hasattr(yade, "MindlinCapillaryPhys"):  # where YADE is built with capillarity
            self._same_places(yade.MindlinCapillaryPhys, yade.MindlinPhys)
            self.classes[at.PHYSICS_CAPILLARY] = self._first_word(yade.MindlinCapillaryPhys)
        probe = yade.Law2_ScGeom_MindlinPhys_Mindlin()
        self.slot = self.find_slot(probe)
        self.step = {}  # words of `find_step` once the self-test has verified them
        self.step_refused = NOT_TRIED  # why not; None where they are used

    @staticmethod
    def _symbol(library, name):
        try:
            return ctypes.cast(getattr(library, name), ctypes.c_void_p).value
        except AttributeError:
            raise BridgeUnavailable(f"YADE's libraries do not export {name}") from None

    @staticmethod
    def _vector(name, cls=yade.MindlinPhys):
        def make(value):
            thing, vector = cls(), yade.Vector3(value, 0, 0)
            if cls is yade.State:  # pos is no argument of State
                setattr(thing, name, vector)
            else:  # shearInc cannot be set otherwise
                thing.updateAttrs({name: vector})
            return thing

        return _find(cls, name, make=make, read=lambda thing: getattr(thing, name)[0])

    @staticmethod
    def _quaternion():
        """Byte offset of State.ori: four doubles, x first."""

        def make(value):
            state = yade.State()
            state.ori = yade.Quaternion(0.5, value, 0.25, 0.125)
            return state

        place = _find(yade.State, "ori", values=(0.1234567, 0.2345678, 0.3456789), make=make, read=lambda state: state.ori[0])
        state = make(0.5)  # referenced while it is read
        if list(read_memory(address(state) + place, 32, ctypes.c_double)) != [state.ori[n] for n in range(4)]:
            raise BridgeUnavailable("State.ori is not four doubles x, y, z, w")
        return place

    @staticmethod
    def _first_word(cls):
        """Address of the table of virtual functions with which objects of a class begin."""
        thing = cls()  # referenced while it is read
        first = ctypes.c_uint64.from_address(_window(thing)[0]).value
        name = f"_ZTVN4yade{len(cls.__name__)}{cls.__name__}E"
        if _symbol_at(first - 16) != name:
            raise BridgeUnavailable(f"{cls.__name__} does not begin with its table of virtual functions {name}")
        return first

    def _same_places(self, cls, base):
        """Raise unless the numbers that the bridge uses are in a derived class where its base has them."""
        names = {yade.ScGeom: PLACES_IN_GEOMETRY, yade.MindlinPhys: PLACES_IN_PHYSICS}[base]
        for name, word in names:
            if _find(cls, name) != self.offsets[word]:
                raise BridgeUnavailable(f"{cls.__name__}.{name} is not where {base.__name__} has it")

    def find_step(self, functor, scene):
        """Find what a contact step without the native `go` needs (`shear.step_alone`), once per process: `functor` has acted in
        this empty scene. The words of the context, or BridgeUnavailable."""
        here, size = _window(functor)
        base = self._symbol(self.library, f"_ZTI{TABLE[4:]}")
        base_kind, _, parent = read_memory(base, 24, ctypes.c_uint64).tolist()
        if _symbol_at(base_kind - 16) != SINGLE_BASE or parent != self._symbol(self.core, "_ZTIN4yade10LawFunctorE"):
            raise BridgeUnavailable(f"{LAW} does not begin with a LawFunctor")
        scenes = 8 * np.flatnonzero(read_memory(here, size, ctypes.c_uint64) == address(scene))
        unknown = {name for name, value in functor.dict().items() if isinstance(value, bool)} - {*OPTIONS, "nothing"}
        if unknown:
            raise BridgeUnavailable(f"{LAW} has the options {', '.join(sorted(unknown))}, which demlaws does not know")
        options = [_find_flag(functor, name) for name in OPTIONS]
        if len(scenes) != 1 or sorted(options) != list(range(min(options), min(options) + 4)):
            raise BridgeUnavailable(f"{LAW} has its scene at {scenes.tolist()} and its options at {options}")
        kind = next((name for name in DAMPING_KINDS if hasattr(yade.MindlinPhys, name)), "betan")
        this = self.slot[0]
        return {
            at.APPLY: self._symbol(self.library, APPLY),
            at.FUNCTOR: this,
            at.SCENE: int(scenes[0]) - this,
            at.OPTIONS: min(options) - this,
            at.PERIODIC: _find_flag(scene, "periodic", yade.O),
            at.KS: _find(yade.MindlinPhys, "ks"),
            at.SHEAR_SUM: self._vector("shearForce"),
            at.SHEAR_VISCOUS: self._vector("shearViscous"),
            at.SLIDING: _find_flag(yade.MindlinPhys(), "isSliding"),
            at.BETAN: _find(yade.MindlinPhys, "betan"),
            at.DAMPING_KIND: _find(yade.MindlinPhys, kind),
        }

    @staticmethod
    def _body_number(name):
        return _find(yade.Interaction, name, ctypes.c_int32, (11223344, 55667788, 99001122))

    def find_slot(self, functor):
        """Where `functor` points to the table of virtual functions that holds `go`: (byte offset, index in table)."""
        start, size = _window(functor)
        words = read_memory(start, size, ctypes.c_uint64)
        if int(words[0]) != self.table + 16:
            raise BridgeUnavailable(f"{functor!r} is not an untouched {LAW}")
        slots = []
        for offset in range(8, size - 7, 8):
            table = int(words[offset // 8])
            if not self.table < table < self.table + 4096:
                continue
            if ctypes.c_int64.from_address(table - 16).value != -offset:
                continue  # a base's table states how far the base lies from the start of the object
            thunk = self._symbol(self.library, GO.replace("_ZN", f"_ZThn{offset}_N", 1))
            entries = read_memory(table, 8 * COPIED, ctypes.c_uint64) if table + 8 * COPIED <= self.table_end else []
            places = [n for n, entry in enumerate(entries[:16]) if int(entry) == thunk]
            slots += [(offset, n, thunk) for n in places]
        if len(slots) != 1:
            raise BridgeUnavailable(f"the virtual function go of {LAW} was found at {len(slots)} places, not one")
        return slots[0]

    @property
    def untested(self):
        """A line about a YADE on which the tests have not run, or None."""
        if self.version in TESTED:
            return None
        return (
            f"this is YADE {self.version}, on which demlaws has not been tested ({', '.join(TESTED)} are): the checks of its "
            "memory layout have passed, and a self-test is made with each kind of law"
        )


_layout = None


def layout():
    """The verified `Layout` of this process, or BridgeUnavailable."""
    global _layout
    if _layout is None:
        if os.uname().sysname != "Linux" or os.uname().machine != "x86_64":
            raise BridgeUnavailable(
                f"the bridge is made for Linux on x86-64, this is {os.uname().sysname} {os.uname().machine}"
            )
        _layout = Layout()
    return _layout


_entries = {}


def _entry(kind, params_kind, shear, mode, rule):
    """Address of native code for laws of this kind."""
    key = (kind, params_kind, type(shear), type(mode), type(rule))  # the tags themselves are empty tuples, all equal
    if key not in _entries:
        _entries[key] = kernel.entry(kind, params_kind, shear, mode, rule, 8 * COPIED)
    return _entries[key].address


_attachments = {}  # address of a patched table of virtual functions → Attachment


def acting(functor):
    """The `Attachment` to which a functor points, or None."""
    offset, _, _ = layout().slot
    return _attachments.get(ctypes.c_uint64.from_address(_window(functor)[0] + offset).value)


def _reserve(count, words):
    """Address space for `count` rows as an array of words: memory is used only where something was written."""
    while True:
        try:
            block = mmap.mmap(-1, 8 * count * words, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | MAP_NORESERVE)
            break
        except OSError:  # ulimit -v
            count //= 2
            if count < 1024:
                raise BridgeUnavailable(f"no memory for the history of {2 * count} contacts") from None
    _forever.append(block)
    return np.frombuffer(block, np.int64).reshape(count, words)


class Attachment:
    """A law made ready for functors: context, pair records and a patched table of virtual functions."""

    def __init__(self, pairs):
        self.layout = layout()
        _, index, thunk = self.layout.slot
        self.context = at.Context()
        words = self.context.words
        for word, value in {**self.layout.offsets, **self.layout.classes, **self.layout.step}.items():
            words[word] = value
        words[at.GO] = thunk
        words[at.BODY_BY_ID] = self.layout.body_by_id
        words[at.SURFACES] = len(pairs.labels)
        words[at.LABEL_HASHES] = pairs.hashes.ctypes.data
        words[at.PAIRS] = pairs.numbers.ctypes.data
        words[at.RECORDS] = pairs.records.ctypes.data
        words[at.RECORD_BYTES] = pairs.records.strides[0]
        words[at.ROW_WORDS], words[at.SPRINGS], words[at.SPRING_COUNT] = pairs.row_words, 8 * pairs.springs_at, pairs.springs
        words[at.FLATS] = pairs.flats == "plane"
        words[at.RADIUS_MODE] = pairs.radii.mode
        words[at.EDGES] = pairs.radii.edges.ctypes.data
        words[at.GAP_RADIUS] = pairs.radii.gap_address()
        self.context.doubles[at.LARGEST_RADIUS] = pairs.radii.shapes.largest if pairs.radii.shapes else 0.0
        self._rows_in_use = 0  # rows that were in use when `collect` last looked
        self._pairs, self._runner = pairs, None  # referenced: native code reads the pairs and writes into the runner
        words[at.GENERATION] = 1 + int.from_bytes(os.urandom(3), "little")
        self.rows, self._free = _reserve(MOST_ROWS, pairs.row_words), np.zeros(0, np.int64)
        words[at.ROWS], words[at.CAPACITY] = self.rows.ctypes.data, len(self.rows)
        probe = yade.Law2_ScGeom_MindlinPhys_Mindlin()
        point = ctypes.c_uint64.from_address(address(probe) + self.layout.find_slot(probe)[0]).value
        self.table = np.zeros(COPIED + 3, np.int64)
        self.table[: COPIED + 2] = read_memory(
            point - 16, 8 * (COPIED + 2), ctypes.c_int64
        )  # from two before its address point
        self.table[2 + index] = _entry(pairs.kind, pairs.params_kind, pairs.shear, pairs.mode, pairs.rule)
        self.table[COPIED + 2] = self.context.address
        _forever.append(self)
        _attachments[self.table.ctypes.data + 16] = self

    def watched_by(self, runner):
        """Set the guard's PyRunner, which native code can have run before the next step; None: no guard."""
        if self._runner is not None:
            self._runner.nDone = 0  # a guard that is still in a scene reports that its law has left
        self._runner = runner
        self.context.words[at.ALARM] = 0 if runner is None else address(runner) + self.layout.number_done

    def _numbers(self, contacts):
        """Numbers of the rows of contacts that the law has seen, -1 for others."""
        marks = np.array([contact.phys.prevU[1] for contact in contacts], float)
        codes = np.abs(np.where(np.isfinite(marks) & (np.abs(marks) < 2.0**53), marks, 0.0)).astype(np.int64)
        mine = codes >> 28 == self.context.words[at.GENERATION]
        return np.where(mine, codes & 0xFFFFFFF, -1)

    def _history(self):
        """All rows' histories as arrays of words, not copied."""
        return self.rows[:, at.ROW_HISTORY // 8 : at.ROW_OWN // 8]

    def rows_of(self, contacts):
        """The contacts' histories as an array of `layout.CONTACT`; tag 0 where the law has not seen the contact."""
        numbers = self._numbers(contacts)
        rows = self._history()[numbers].view(at.CONTACT)[:, 0]  # a copy
        rows["tag"][numbers < 0] = 0.0
        return rows

    def saved(self, contacts):
        """(id1, id2, then words of history and springs) of contacts that the law has seen: what `restore` takes."""
        numbers = self._numbers(contacts)
        bodies = np.array([(c.id1, c.id2) for c in contacts], np.int64).reshape(-1, 2)[numbers >= 0]
        numbers = numbers[numbers >= 0]
        return np.hstack([bodies, self._history()[numbers], self.rows[numbers, self._pairs.springs_at :]])

    def restore(self, saved, contacts):
        """Give contacts of a scene that was loaded the rows that `saved` has of them."""
        words_of_pair = {(int(row[0]), int(row[1])): row[2:] for row in saved}
        history = at.CONTACT.itemsize // 8
        words = self.context.words
        for contact in contacts:
            phys, words_of_row = contact.phys, words_of_pair.get((contact.id1, contact.id2))
            phys.prevU = yade.Vector3.Zero
            if words_of_row is None:
                continue
            number = int(words[at.ROWS_USED])
            words[at.ROWS_USED] += 1
            self.rows[number] = 0
            self._history()[number] = words_of_row[:history]
            self.rows[number, self._pairs.springs_at :] = words_of_row[history:]
            row = self.rows.ctypes.data + number * self.rows.strides[0]
            places = address(phys), address(contact)
            kernel.fill_row(self._pairs.kind, self.context.address, row, number, *places)

    def collect(self, contacts):
        """Between steps: make rows of contacts that have ended or were erased free again, once they are the larger part.

        contacts: function of all contacts of the one scene in which the law has acted, or None.
        """
        words = self.context.words
        count = int(words[at.ROWS_USED])
        if words[at.FREE_TAKEN] < words[at.FREE_COUNT] or count < 2 * self._rows_in_use + FEW_ROWS:
            return
        live = self._history()[:count].view(at.CONTACT)[:, 0]["tag"] != 0.0
        if contacts is not None and 2 * live.sum() > count:
            mine = self._numbers(contacts())
            live = np.isin(np.arange(count), mine)
            self.rows[:count][~live] = 0
        self._free = np.flatnonzero(~live)
        words[at.FREE], words[at.FREE_COUNT], words[at.FREE_TAKEN] = self._free.ctypes.data, len(self._free), 0
        self._rows_in_use = max(int(live.sum()), count // 4)

    def set_radius(self, contact, radius):
        """Give a contact that the law has seen another R, and its row what follows from it."""
        number = int(self._numbers([contact])[0])
        self._history()[number].view(at.CONTACT)["radius"] = radius
        row = self.rows.ctypes.data + number * self.rows.strides[0]
        places = address(contact.phys), address(contact)
        kernel.fill_row(self._pairs.kind, self.context.address, row, number, *places)

    def forget_rows(self):
        """All contacts are gone."""
        self.context.words[[at.ROWS_USED, at.FREE_COUNT, at.FREE_TAKEN]] = 0
        self._rows_in_use = 0

    def watch_itself(self):
        """Act without a guard, for a test: who calls this looks for faults."""
        self._alarm = np.zeros(1, np.int64)
        self.context.words[at.ALARM] = self._alarm.ctypes.data

    def live(self):
        """Histories of the law's contacts in all scenes (`layout.CONTACT`), and the addresses of their interactions."""
        rows = self.rows[: min(int(self.context.words[at.ROWS_USED]), len(self.rows))]
        rows = rows[rows[:, at.ROW_PHYSICS // 8] != 0]
        history = np.ascontiguousarray(rows[:, at.ROW_HISTORY // 8 : at.ROW_OWN // 8])
        return history.view(at.CONTACT)[:, 0], rows[:, at.ROW_INTERACTION // 8].copy()

    def bodies_of(self, interaction):
        """Numbers of the two bodies of the interaction at an address, which must be alive."""
        offsets = self.layout.offsets[at.BODY1], self.layout.offsets[at.BODY2]
        return tuple(ctypes.c_int32.from_address(int(interaction) + offset).value for offset in offsets)

    def patch(self, functor):
        """Make `functor` act by this law: an unchanged Mindlin functor, or one that acts by a law of ours."""
        offset, _, _ = self.layout.slot if acting(functor) is not None else self.layout.find_slot(functor)
        ctypes.c_uint64.from_address(address(functor) + offset).value = self.table.ctypes.data + 16

    def acts_in(self, functor):
        """Whether `functor` calls this law."""
        offset, _, _ = self.layout.slot
        return ctypes.c_uint64.from_address(_window(functor)[0] + offset).value == self.table.ctypes.data + 16
