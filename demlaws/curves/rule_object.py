"""A law's own unloading rule as native code, for engines in C++: a small shared object beside a table file.

The rule's compiled functions, with the law's own Params beside them, are written out as an object file and linked with nothing
but the C library. First loading stays the table's: the rule asks the engine for it (`demlaws_rule.h`). The table file holds
size and check value of the object, and an engine that finds none, or another, refuses the table.
"""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from demlaws.core.dispatch import bind, function_of_text, scale, step, stored_and_dissipated
from demlaws.core.fastmath import hertz_coefficient, kernel
from demlaws.core.shear import unloading_stiffness
from demlaws.errors import DemlawsError


class NativeParams(NamedTuple):
    """One contact of a table in an engine: the law's own Params, and where the engine answers for first loading."""

    hertz_coefficient: float  # (4/3) E* √R [N/m^1.5]
    own: tuple
    engine: int  # address of a demlaws::FirstLoading


def _pointer(builder, address, place):
    """The function pointer at `place` of the record at this address."""
    slot = builder.inttoptr(builder.add(address, ir.Constant(ir.IntType(64), 8 * place)), ir.IntType(64).as_pointer())
    return builder.load(slot)


@intrinsic
def _first_loading(typing_context, engine, overlap):
    """Force, stiffness, Hertz-equivalent overlap and a²/R of the table."""

    def generate(context, builder, signature, arguments):
        double = ir.DoubleType()
        kind = ir.FunctionType(ir.VoidType(), [ir.IntType(64), double, double.as_pointer()])
        function = builder.inttoptr(_pointer(builder, arguments[0], 0), kind.as_pointer())
        room = builder.alloca(double, 4)
        builder.call(function, [arguments[0], arguments[1], room])
        places = [builder.load(builder.gep(room, [ir.Constant(ir.IntType(32), n)])) for n in range(4)]
        return context.make_tuple(builder, signature.return_type, places)

    return types.UniTuple(types.float64, 4)(types.int64, types.float64), generate


def _number_of(place):
    @intrinsic
    def ask(typing_context, engine, value):
        def generate(context, builder, signature, arguments):
            double = ir.DoubleType()
            kind = ir.FunctionType(double, [ir.IntType(64), double])
            function = builder.inttoptr(_pointer(builder, arguments[0], place), kind.as_pointer())
            return builder.call(function, [arguments[0], arguments[1]])

        return types.float64(types.int64, types.float64), generate

    return ask


_first_inverse, _first_energy = _number_of(1), _number_of(2)


@kernel
def _virgin(p, overlap):
    return _first_loading(p.engine, overlap)


@kernel
def _inverse(p, force):
    return _first_inverse(p.engine, force)


@kernel
def _energy(p, overlap):
    return _first_energy(p.engine, overlap)


@kernel
def _parts(p):
    return p, p.own, 1.0


bind(NativeParams, virgin=_virgin, inverse=_inverse, energy=_energy, parts=_parts)

_DOUBLES = types.CPointer(types.float64)
_CONTACT = (types.int64, types.float64, types.float64, types.float64, types.float64)  # engine, R, E*, σ, δ; SI


def _functions(shape, tag, size):
    """Name → (signature, function) of what the object exports; the state is `size` doubles."""
    names = {"scale": scale, "step": step, "energies": stored_and_dissipated, "unloading_stiffness": unloading_stiffness}
    names |= {"SHAPE": shape, "TAG": tag, "NativeParams": NativeParams, "hertz_coefficient": hertz_coefficient}
    state = "".join(f"state[{n}], " for n in range(size))
    head = "p = NativeParams(hertz_coefficient(R, E), scale(SHAPE, R, E, s), engine)"
    contact = [
        head,
        f"force, stiffness, new = step(TAG, p, overlap, ({state}))",
        "out[0], out[1], out[2] = force, stiffness, unloading_stiffness(TAG, p, overlap, force, stiffness, new)",
        *(f"state[{n}] = new[{n}]" for n in range(size)),
    ]
    energies = [head, f"out[0], out[1] = energies(TAG, p, overlap, ({state}))"]
    signature, arguments = types.void(*_CONTACT, _DOUBLES, _DOUBLES), "engine, R, E, s, overlap, state, out"
    return {
        "demlaws_rule_contact": (signature, function_of_text(arguments, contact, names)),
        "demlaws_rule_energies": (signature, function_of_text(arguments, energies, names)),
    }


def _object(name, signature, function):
    """The object file (bytes) of one function under a C name, for any processor of this kind."""
    compiled = numba.cfunc(signature, error_model="numpy", fastmath={"contract"}, nogil=True)(function)
    module = llvm.parse_assembly(compiled.inspect_llvm())
    module.get_function(compiled.native_name).name = name
    target = llvm.Target.from_triple(module.triple or llvm.get_process_triple())
    machine = target.create_target_machine(opt=3, reloc="pic", codemodel="small")
    return machine.emit_object(module)


def _linked(objects):
    """Shared object of object files; DemlawsError where it would need more than the C library."""
    compiler = os.environ.get("CXX", "g++")
    if not shutil.which(compiler):
        raise DemlawsError(f"a user-defined rule is linked by {compiler!r}, which was not found: sudo apt install g++")
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for name, data in objects.items():
            files.append(Path(folder, f"{name}.o"))
            files[-1].write_bytes(data)
        exports = Path(folder, "export.map")
        exports.write_text(f"{{ global: {'; '.join(objects)}; local: *; }};\n")
        library = Path(folder, "rule.so")
        line = [compiler, "-shared", "-s", "-Wl,--build-id=none", f"-Wl,--version-script={exports}", "-Wl,--no-undefined"]
        result = subprocess.run([*line, "-o", str(library), *map(str, files), "-lm"], capture_output=True, text=True)
        if result.returncode:
            lines = [text for text in result.stderr.splitlines() if "undefined reference" in text] or result.stderr.splitlines()
            raise DemlawsError(
                f"the rule cannot be linked without Python: {lines[0].strip() if lines else 'the linker failed'}; it "
                "must not raise, print, make arrays or call Python"
            )
        return library.read_bytes()


def rule_object(rule, shape) -> bytes:
    """The shared object of a law's own rule: the law's Shape (its options) is part of it. Raises DemlawsError."""
    functions = _functions(shape, rule.tag, len(rule.state))
    return _linked({name: _object(name, *parts) for name, parts in functions.items()})
