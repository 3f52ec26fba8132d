"""The native bridge: our law as the `go` of a native Law2_ScGeom_MindlinPhys_Mindlin. All that depends on YADE's binary.

YADE is C++; Debian ships no headers, and YADE never calls the `go` of a Python subclass. So a functor object gets a private
copy of its table of virtual functions, with `go` replaced by compiled code (`kernel.go`) that applies Mindlin's law with our
force and stiffness, by itself or by calling the native `go`. Every other functor keeps the original table, and the rest of
YADE's memory is unchanged.

All assumptions are checked: against exported symbols, against the layout rules of the Itanium C++ ABI, and on objects made for
this check (`search`). If one does not hold, `BridgeUnavailable` is raised and nothing has been patched.

A preloaded shared object that interposes `go` is no faster, needs a compiler or a binary and a launcher, and acts on every
Mindlin functor of the process. It would survive `O.load`; here a guard attaches the law again.
"""

import ctypes
import mmap
import os
import weakref

import numpy as np
import yade
import yade.config
from numpy.lib.recfunctions import repack_fields

from demlaws.errors import BridgeWarning, DemlawsError, warn
from demlaws.yade import kernel, layout, objects
from demlaws.yade.friction import ByPressure
from demlaws.yade.omega import O, scratch_scene, set_engines
from demlaws.yade.records import memory_at
from demlaws.yade.search import (
    BridgeUnavailable,
    address,
    columns,
    find_axes,
    find_content,
    find_member,
    find_pointer,
    find_shift_velocity,
    find_string,
    find_vector,
    find_word,
    mapped,
    mapped_until,
    read_memory,
    symbol,
    symbol_at,
    type_of,
    window,
)

TESTED = ("2022.01a", "2023.02a", "2025.2.0", "2026.1.0")
"""Versions on which the tests have run; the checks below decide for every other one."""
LAW = "Law2_ScGeom_MindlinPhys_Mindlin"
GO = f"_ZN4yade{len(LAW)}{LAW}2goERN5boost10shared_ptrINS_5IGeomEEERNS2_INS_5IPhysEEEPNS_11InteractionE"
TABLE = f"_ZTVN4yade{len(LAW)}{LAW}E"
BODY_BY_ID = "_ZN4yade4Body4byIdEiPNS_5SceneE"
CONST_VECTOR = "RKN5Eigen6MatrixIdLi3ELi1ELi0ELi3ELi1EEE"
ROTATE = f"_ZNK4yade6ScGeom6rotateE{CONST_VECTOR.replace('K', '', 1)}"
APPLY = f"_ZN4yade4Shop24applyForceAtContactPointE{CONST_VECTOR}S5_iS5_iS5_PNS_5SceneE"
"""Not that of LawFunctor, which is inline: with link-time optimisation (Ubuntu's packages) no library exports it."""
OPTIONS = ("includeAdhesion", "calcEnergy", "includeMoment", "neverErase")
"""Options of Mindlin's law with which `mindlin.own_step` is not used."""
SLIP_OF_ITS_OWN = "preventGranularRatcheting"
"""Option of versions (2022.01a) whose native law does not read ScGeom.shearInc, into which the correction of a step is written:
under load only `mindlin.own_step` acts. Newer ones accept the name as `nothing`."""
DAMPING_EXPONENTS = ("alpha", "beta")
"""Names that MindlinPhys had for the exponent of another viscous damping."""
SINGLE_BASE = "_ZTVN10__cxxabiv120__si_class_type_infoE"
ROUND_SHAPES = ("Sphere", "GridNode", "GridConnection", "PFacet", "ChainedCylinder")
"""Shapes with a radius of their own, where YADE has them."""
GEOMETRIES = ("ScGeom", "ScGeom6D", "ScGridCoGeom", "CylScGeom", "CylScGeom6D", "ChCylGeom6D")
"""Classes derived from ScGeom: spheres touch grids, facets between grid nodes, and chained cylinders by these."""
MORE_MEMORY = "raise the limit of memory (`ulimit -v`), or make fewer contacts or laws in this process"
FEW_ROWS = 1024
"""Rows that are made before rows are looked for that may be used again."""
COPIED = 64  # words of a virtual table that are copied; Mindlin's has 8

_keep_alive = []  # never freed, since native code may still point there
_libc = ctypes.CDLL(None)
_libc.mmap.restype = ctypes.c_void_p
_libc.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int, ctypes.c_int, ctypes.c_int, ctypes.c_long]
_libc.munmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t]


class Layout:
    """Addresses and offsets in this process's YADE, found and verified once; `objects` has the dtypes."""

    def __init__(self):
        self.version = yade.config.version
        if getattr(yade.config, "highPrecisionBits", 64) != 64:  # its suffix is whatever it was built with
            raise BridgeUnavailable(f"this YADE computes in {yade.config.highPrecisionName}; the bridge needs double")
        if ctypes.sizeof(ctypes.c_void_p) != 8:
            raise BridgeUnavailable("the bridge needs a 64-bit machine")
        self.library, self.core = ctypes.CDLL(mapped("/libpkg_dem.so")), ctypes.CDLL(mapped("/libyade.so"))
        self.table = symbol(self.library, TABLE)
        self.table_end = mapped_until(self.table)
        self.number_done = find_member(yade.PyRunner(), "nDone", "i8")[-1]
        self.slot = self.find_slot(yade.Law2_ScGeom_MindlinPhys_Mindlin())
        self.addresses = self._find_classes() | {
            "go": self.slot[2],
            "body_by_id": symbol(self.core, BODY_BY_ID),
            "apply_force": symbol(ctypes.CDLL(mapped("/libpre_dem.so")), APPLY),
            "functor_offset": self.slot[0],
        }
        members = self.find_members()
        axes = find_axes(symbol(self.library, ROTATE))
        members["ScGeom"] |= {name: (*objects.VECTOR, place) for name, place in zip(objects.AXES, axes, strict=True)}
        objects.define(**members, **self._find_members_of_scene())
        self.own_step_is_proved = False  # by the first self-test

    @staticmethod
    def find_members():
        """Members that a contact step uses: name of a class → {field: (format, offset)}."""
        numbers = {
            yade.ScGeom: ("penetrationDepth", "refR1", "refR2"),
            yade.MindlinPhys: ("kn", "ks", "kno", "kso", "tangensOfFrictionAngle", "betan", "betas"),
            yade.State: ("mass",),
        }
        vectors = {
            yade.ScGeom: ("normal", "contactPoint", "shearInc"),
            yade.MindlinPhys: (
                *("shearElastic", "usElastic", "usTotal", "prevU"),
                *("normalForce", "shearForce", "normalViscous", "shearViscous"),
            ),
            yade.State: ("pos", "vel", "angVel"),
        }
        found = {
            cls.__name__: {name: find_member(cls(), name) for name in names}
            | {name: find_vector(cls(), name) for name in vectors[cls]}
            for cls, names in numbers.items()
        }
        found["ScGeom"]["vtable"] = found["MindlinPhys"]["vtable"] = "i8", 0
        found["MindlinPhys"]["isSliding"] = find_member(yade.MindlinPhys(), "isSliding", "u1")
        if hasattr(yade.MindlinPhys, "initD"):  # where YADE is built with partial saturation
            found["MindlinPhys"]["initD"] = find_member(yade.MindlinPhys(), "initD")
        for name in DAMPING_EXPONENTS:
            if hasattr(yade.MindlinPhys, name):
                found["MindlinPhys"]["damping_exponent"] = find_member(yade.MindlinPhys(), name)
        kinds_of_conical = {"R": "f8", "mu0": "f8", "c1": "f8", "c2": "f8", "isYielding": "u1"}
        found["MindlinPhysCDM"] = {
            name: find_member(yade.MindlinPhysCDM(), name, kind) if hasattr(yade, "MindlinPhysCDM") else (kind, 0)
            for name, kind in kinds_of_conical.items()
        }
        turns = [yade.Quaternion(0.5, part, 0.25, 0.125) for part in (0.1, 0.2, 0.3)]
        found["State"]["ori"] = find_member(yade.State(), "ori", settings=turns, encode=list)
        found["State"]["blockedDOFs"] = find_member(yade.State(), "blockedDOFs", "u4", ("xX", "yZ", "zXZ"), axes_as_bits)
        found["Interaction"] = {name: find_member(yade.Interaction(), name, "i4") for name in ("id1", "id2")}
        distances = [yade.Vector3i(cells, 7, -5) for cells in (112233, 223344, 334455)]
        found["Interaction"]["cellDist"] = find_member(yade.Interaction(), "cellDist", "i4", distances)
        parts = {"material": yade.FrictMat, "shape": yade.Sphere, "state": yade.State}
        found["Body"] = {name: find_pointer(yade.Body, name, cls) for name, cls in parts.items()}
        label = find_string(yade.FrictMat, "label")
        found["Material"] = {"label": ("i8", label), "label_length": ("i8", label + 8)}
        return found

    def _find_classes(self):
        """Types of the classes that native code knows; raises unless derived classes have the members
        where their bases have them."""
        names = {"physics": "MindlinPhys", "facet": "Facet", "wall": "Wall", "box": "Box"}
        addresses = {name: type_of(getattr(yade, cls)) for name, cls in names.items()}
        addresses["capillary"] = addresses["physics"]
        if hasattr(yade, "MindlinCapillaryPhys"):  # where YADE is built with capillarity
            self._same_places(yade.MindlinCapillaryPhys, yade.MindlinPhys, ("kn", "kno", "kso"))
            addresses["capillary"] = type_of(yade.MindlinCapillaryPhys)
        addresses["conical"] = 0
        if hasattr(yade, "MindlinPhysCDM"):
            self._same_places(yade.MindlinPhysCDM, yade.MindlinPhys, ("kn", "kno", "kso", "tangensOfFrictionAngle"))
            addresses["conical"] = type_of(yade.MindlinPhysCDM)
        geometries = [getattr(yade, name) for name in GEOMETRIES if hasattr(yade, name)]
        for cls in geometries:
            self._same_places(cls, yade.ScGeom, ("penetrationDepth", "refR1", "refR2"))
        self.geometries = [type_of(cls) for cls in geometries]
        self.round_shapes = [type_of(getattr(yade, name)) for name in ROUND_SHAPES if hasattr(yade, name)]
        return addresses

    @staticmethod
    def _same_places(cls, base, names):
        for name in names if cls is not base else ():
            if find_member(cls(), name) != find_member(base(), name):
                raise BridgeUnavailable(f"{cls.__name__}.{name} is not where {base.__name__} has it")

    def _find_members_of_scene(self):
        """The same of functor, scene and cell, which refer to each other."""
        if O.running:
            raise DemlawsError(
                "a simulation runs, in which the scene's own members cannot be looked for: `import demlaws.yade` and make laws "
                "before O.run"
            )
        with scratch_scene():
            scene, functor = O._sceneObj, yade.Law2_ScGeom_MindlinPhys_Mindlin()
            O.periodic = True
            O.cell.hSize, O.cell.velGrad, O.dt = yade.Matrix3(2, 1, 3, 5, 4, 6, 7, 9, 8), yade.Matrix3.Identity * 0.125, 0.5
            set_engines([yade.ForceResetter(), yade.LawDispatcher([functor]), yade.NewtonIntegrator()])
            for _ in range(2):  # the functor gets its scene, and the cell differs from what it was
                O.step()
            options = self._find_options(functor)
            cell = find_word(scene, O.cell)  # before the flag of a periodic scene is looked for
            size = find_content("Cell.hSize", [(O.cell, columns(O.cell.hSize))])
            periodic = find_member(scene, "periodic", "u1", owner=O)
            step = find_member(scene, "dt", settings=(1.25e-7, 2.5e-7, 3.125e-7), owner=O)
            return {
                "Functor": {"scene": find_word(functor, scene), "options": ("u4", options)},
                "Scene": {"isPeriodic": periodic, "dt": step, "cell": cell},
                "Cell": {"hSize": ("f8", (3, 3), size), "shiftVelocity": ("f8", (3, 3), find_shift_velocity())},
            }

    def _find_options(self, functor):
        """Byte offset of the four flags in a functor, which begins with a LawFunctor."""
        base = symbol(self.library, f"_ZTI{TABLE[4:]}")
        base_kind, _, parent = read_memory(base, 24, ctypes.c_uint64).tolist()
        if symbol_at(base_kind - 16) != SINGLE_BASE or parent != symbol(self.core, "_ZTIN4yade10LawFunctorE"):
            raise BridgeUnavailable(f"{LAW} does not begin with a LawFunctor")
        flags = {name: value for name, value in functor.dict().items() if isinstance(value, bool)}
        self.own_slip = SLIP_OF_ITS_OWN in flags
        self.unknown = {name: value for name, value in flags.items() if name not in (*OPTIONS, "nothing")}
        options = sorted(find_member(functor, name, "u1")[-1] for name in OPTIONS)
        if options != list(range(options[0], options[0] + 4)):
            raise BridgeUnavailable(f"{LAW} has its options at {options}")
        return options[0]

    def find_slot(self, functor):
        """Where `functor` points to the table of virtual functions that holds `go`: (byte offset, index in table)."""
        start, size = window(functor)
        words = read_memory(start, size, ctypes.c_uint64)
        if int(words[0]) != self.table + 16:
            raise BridgeUnavailable(f"{functor!r} is not an untouched {LAW}")
        slots = []
        for offset in range(8, size - 7, 8):
            table = int(words[offset // 8])
            if not self.table < table < self.table + 4096:
                continue
            if memory_at(table - 16, ctypes.c_int64).value != -offset:
                continue  # a base's table states how far the base lies from the start of the object
            thunk = symbol(self.library, GO.replace("_ZN", f"_ZThn{offset}_N", 1))
            entries = read_memory(table, 8 * COPIED, ctypes.c_uint64) if table + 8 * COPIED <= self.table_end else []
            places = [n for n, entry in enumerate(entries[:16]) if int(entry) == thunk]
            slots += [(offset, n, thunk) for n in places]
        if len(slots) != 1:
            raise BridgeUnavailable(f"the virtual function go of {LAW} was found at {len(slots)} places, not one")
        return slots[0]


def axes_as_bits(axes):
    """State.blockedDOFs as YADE keeps it: a bit for each letter of xyzXYZ."""
    return sum(1 << "xyzXYZ".index(axis) for axis in axes)


_layout = None


def find_layout():
    """The verified `Layout` of this process, or BridgeUnavailable."""
    global _layout
    if _layout is None:
        if os.uname().sysname != "Linux" or os.uname().machine != "x86_64":
            raise BridgeUnavailable(
                f"it needs Linux on a processor of x86-64, this is {os.uname().sysname} {os.uname().machine}"
            )
        try:
            _layout = Layout()
        except (AttributeError, TypeError) as error:  # a member that this YADE does not have
            raise BridgeUnavailable(str(error)) from None
        if _layout.version not in TESTED:
            warn(
                f"this is YADE {_layout.version}, on which demlaws has not been tested ({', '.join(TESTED)} are): the checks "
                "of its memory layout have passed, and a self-test is made with each kind of law",
                BridgeWarning,
            )
    return _layout


_entries = {}


def _entry(pairs):
    """Address of native code for laws of this kind."""
    # tags are empty tuples, all equal: by their names
    key = repr(pairs.law), pairs.records.dtype, pairs.row, objects.identity()
    if key not in _entries:
        _entries[key] = kernel.entry(pairs, 8 * COPIED)
    return _entries[key].address


class Rows:
    """The rows of a law's contacts: blocks of memory that are made when contacts need them, by native code or here."""

    def __init__(self, dtype, context):
        self.dtype, self.context = dtype, context
        # pages that are not written to are not resident: YADE keeps the functor of a law after O.reset, and so its addresses
        private = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
        self.blocks = np.frombuffer(mmap.mmap(-1, 8 * layout.BLOCKS, flags=private), np.int64)
        context["blocks"], context["map_memory"] = self.blocks.ctypes.data, ctypes.cast(_libc.mmap, ctypes.c_void_p).value
        self.size = layout.ROWS * dtype.itemsize
        self.release()
        weakref.finalize(self, _retire, context, self.blocks, self.size).atexit = False

    def release(self):
        """All contacts are gone: return the memory; a row of before is not taken for one of those to come."""
        _unmap(self.blocks, self.size)
        for name in ("rows_used", "free_count", "free_taken"):
            self.context[name] = 0
        self.context["collect_at"] = FEW_ROWS
        self.context["generation"] = 1 + int.from_bytes(os.urandom(6), "little")

    def addresses(self, contacts):
        """Addresses of the rows of contacts that the law has seen, 0 for others."""
        marks = np.array([tuple(contact.phys.prevU) for contact in contacts], float).reshape(-1, 3)
        mine = marks[:, 2] == self.context["generation"]
        return np.abs(np.where(mine, marks[:, 1], 0.0)).astype(np.int64)

    def at(self, addresses):
        """Copies of the rows at addresses, zeros for 0."""
        words = np.zeros((len(addresses), self.dtype.itemsize // 8), np.int64)
        kernel.gather_rows(addresses, words)
        return words.view(self.dtype)[:, 0]

    def used(self):
        """Blocks of rows that contacts have or have had, not copied, in order, up to one for which there was no memory."""
        count = min(int(self.context["rows_used"]), layout.ROWS * layout.BLOCKS)
        for number, block in enumerate(self.blocks[: -(-count // layout.ROWS)].tolist()):
            if block == 0:
                return
            rows = read_memory(block, self.size, ctypes.c_uint8).view(self.dtype)
            yield rows[: count - number * layout.ROWS]


def _retire(context, blocks, size):
    """Return the memory of a law that is gone. If native code calls it again, it finds all rows in use, and gives no force."""
    context["generation"], context["rows_used"], context["free_count"], context["blocks"] = (
        -1,
        layout.ROWS * layout.BLOCKS,
        0,
        0,
    )
    _unmap(blocks, size)


def _unmap(blocks, size):
    for block in blocks[blocks != 0].tolist():
        _libc.munmap(block, size)
    blocks[blocks != 0] = 0


class Attachment:
    """A law made ready for functors: context, pairs of surfaces, rows and a patched table of virtual functions."""

    def __init__(self, pairs):
        self.layout, self.context = find_layout(), layout.Context()
        self._fill_context(pairs)
        self.saved_dtype = pairs.saved
        self._pairs, self.runner = pairs, None  # referenced: native code reads the pairs and writes into the runner
        self.rows, self._free = Rows(pairs.row, self.context), np.zeros(0, np.int64)
        probe = yade.Law2_ScGeom_MindlinPhys_Mindlin()
        offset, index, _ = self.layout.find_slot(probe)
        point = memory_at(address(probe) + offset).value
        self.table = np.zeros(COPIED + 3, np.int64)
        self.table[: COPIED + 2] = read_memory(
            point - 16, 8 * (COPIED + 2), ctypes.c_int64
        )  # from two before its address point
        self.table[2 + index] = _entry(pairs)
        self.table[COPIED + 2] = self.context.address
        _keep_alive.append((self.table, self.context))

    def _fill_context(self, pairs):
        context, found = self.context, self.layout
        for name, value in found.addresses.items():
            context[name] = value
        for name, classes in (("geometry", found.geometries), ("round_shape", found.round_shapes)):
            context[f"{name}_classes"][: len(classes)] = classes
            context[f"{name}_count"] = len(classes)
        context["own_step"], context["native_step"] = 1, not found.own_slip
        context["by_pressure"] = isinstance(pairs.friction.tag, ByPressure)
        context["surfaces"], context["labels"] = len(pairs.labels), pairs.encoded_labels.ctypes.data
        context["label_size"] = pairs.encoded_labels.itemsize
        context["pair_numbers"], context["pairs"] = pairs.numbers.ctypes.data, pairs.records.ctypes.data
        context["plane_flats"] = pairs.flats == "plane"
        context["shear_ratio"] = pairs.shear_ratio or 0.0  # 0: of the materials
        pairs.radii.fill(context)

    def watched_by(self, runner):
        """Set the guard's PyRunner, which native code can have run before the next step; None: no guard."""
        if self.runner is not None:
            self.runner.nDone = 0  # a guard that is still in a scene reports that its law has left
        self.runner = runner
        self.context["guard_counter"] = 0 if runner is None else address(runner) + self.layout.number_done

    def rows_of(self, contacts):
        """The contacts as an array of `layout.contact_dtype`, with the Params by which YADE has their forces; tag 0 where the
        law has not seen the contact."""
        rows = self.rows.at(self.rows.addresses(contacts))
        return repack_fields(rows[[*self._pairs.contact.names]])

    def saved(self, contacts):
        """Bodies and rows, without addresses, of contacts that the law has seen: what `restore` takes."""
        addresses = self.rows.addresses(contacts)
        bodies = np.array([(c.id1, c.id2) for c in contacts], np.int64).reshape(-1, 2)[addresses != 0]
        return bodies, repack_fields(self.rows.at(addresses[addresses != 0])[[*self.saved_dtype.names]])

    def restore(self, bodies, saved, contacts):
        """Give contacts of a scene that was loaded the rows that `saved` has of them."""
        place_of = {pair: place for place, pair in enumerate(map(tuple, bodies.tolist()))}
        for contact in contacts:
            contact.phys.prevU = yade.Vector3.Zero
            place = place_of.get((contact.id1, contact.id2))
            if place is None:
                continue
            row_address = kernel.new_row(self.context.record, self.rows.dtype)
            if row_address == 0:
                raise DemlawsError(f"no memory for the history of contact {contact.id1}+{contact.id2}: {MORE_MEMORY}")
            rows = read_memory(row_address, self.rows.dtype.itemsize, ctypes.c_uint8).view(self.rows.dtype)
            row = rows[0]
            for name in saved.dtype.names:
                row[name] = saved[name][place]
            number = int(row["tag"]) - 1
            row["phys"], row["interaction"] = address(contact.phys), address(contact)
            row["pair"] = self.context["pairs"] + number * self._pairs.records.itemsize
            kernel.fill_loop(self._pairs.law, self._pairs.records, rows)
            smooth = row["hertz"] != 0.0 or row["modulus"] == 0.0
            contact.phys.prevU = yade.Vector3(0.0, -row_address if smooth else row_address, self.context["generation"])

    def collect(self, contacts):
        """Between steps: make rows of contacts that have ended or were erased free again, before the free ones are used up.

        contacts: function that returns all contacts of the scene.
        """
        context = self.context
        count = int(context["rows_used"])
        if (context["free_taken"] if context["free_count"] else count) < context["collect_at"]:
            return
        blocks = list(self.rows.used())
        if not blocks:
            return
        live = np.concatenate([rows["tag"] != 0.0 for rows in blocks])
        count = len(live)
        if 2 * live.sum() > count:
            known = self.rows.addresses(contacts())
            places = [rows.ctypes.data + rows.itemsize * np.arange(len(rows)) for rows in blocks]
            live = np.isin(np.concatenate(places), known)
            for first, rows in zip(range(0, count, layout.ROWS), blocks, strict=True):
                rows[~live[first : first + layout.ROWS]] = np.zeros((), rows.dtype)
        free = np.flatnonzero(~live)
        if 8 * len(free) < count:  # not worth it: take new rows until there are 50 % more
            free = free[:0]
        self._free, context["free"] = free, free.ctypes.data
        context["free_count"], context["free_taken"] = len(free), 0
        context["collect_at"] = len(free) - len(free) // 8 if len(free) else count + count // 2 + FEW_ROWS

    def patch(self, functor):
        """Make a Mindlin functor that is unchanged act by this law."""
        self.layout.find_slot(functor)
        self.point(functor)

    def point(self, functor):
        """Make a functor that acts by a law of ours act by this one."""
        memory_at(address(functor) + self.layout.slot[0]).value = self.table.ctypes.data + 16

    def acts_in(self, functor):
        """Whether `functor` calls this law."""
        return memory_at(window(functor)[0] + self.layout.slot[0]).value == self.table.ctypes.data + 16
