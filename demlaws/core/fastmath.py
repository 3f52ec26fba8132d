"""Compiled elementary functions that LLVM can vectorise: no branch, no library call, no table in memory.

Debian's and PyPI's numba (0.62 and later) have no vector library, so ``x ** q`` and ``cbrt`` in a loop cost a scalar call
per element. The functions here cost about as much as a square root in a vectorised loop. This is the only module with
bit tricks; errors quoted are measured by tests/core/test_fastmath.py in units of ε = 2.2e-16.
"""

import numpy as np
from llvmlite import ir
from numba import types

from demlaws.core.numba_compat import kernel, native


def bits(x):
    """The IEEE-754 bit pattern of a double, as a signed 64-bit integer."""
    return np.float64(x).view(np.int64)


@native(bits, lambda x: types.int64(types.float64))
def _bits(context, builder, signature, arguments):
    return builder.bitcast(arguments[0], ir.IntType(64))


def from_bits(pattern):
    """The double that has this bit pattern."""
    return np.int64(pattern).view(np.float64)


@native(from_bits, lambda pattern: types.float64(types.int64))
def _from_bits(context, builder, signature, arguments):
    return builder.bitcast(arguments[0], ir.DoubleType())


def sqrt(x):
    """Square root of a double as LLVM's own operation: math.sqrt calls a function that may set errno, which forbids
    vectorisation under a condition."""
    return np.sqrt(x)


@native(sqrt, lambda x: types.float64(types.float64))
def _sqrt(context, builder, signature, arguments):
    function = builder.module.declare_intrinsic("llvm.sqrt", [ir.DoubleType()])
    return builder.call(function, arguments)


def read_only(array):
    """Pointer to the doubles of an array, with the promise that nothing else writes to them while it is in use.

    Without the promise a loop that looks up a table could not be vectorised: what it stores might change the table.
    A pointer also carries no reference count, which numba would update for every contact. In Python: the array.
    """
    return array


@native(read_only, lambda array: types.CPointer(types.float64)(array))
def _read_only(context, builder, signature, arguments):
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    name, kind = "demlaws.read_only", ir.FunctionType(data.type, [data.type])
    function = builder.module.globals.get(name)
    if function is None:  # to LLVM a function that returns fresh memory, and cannot be looked into
        function = ir.Function(builder.module, kind, name)
        function.linkage = "internal"
        function.attributes.add("noinline")
        function.return_value.add_attribute("noalias")
        inside = ir.IRBuilder(function.append_basic_block())
        inside.ret(inside.asm(kind, "", "=r,0", function.args, side_effect=False))
    return builder.call(function, [data])


def row_of_four(rows, number):
    """The four doubles of one row of a C-ordered (n, 4) array, or of what `read_only` made of it. No bounds check."""
    return tuple(rows[number])


@native(row_of_four, lambda rows, number: types.UniTuple(types.float64, 4)(rows, number))
def _row_of_four(context, builder, signature, arguments):
    data, (rows, number) = arguments[0], signature.args
    if isinstance(rows, types.Array):
        data = context.make_array(rows)(context, builder, data).data
    first = builder.mul(context.cast(builder, arguments[1], number, types.int64), ir.Constant(ir.IntType(64), 4))
    places = [builder.add(first, ir.Constant(ir.IntType(64), k)) for k in range(4)]
    return context.make_tuple(builder, signature.return_type, [builder.load(builder.gep(data, [p])) for p in places])


_SQRT_HALF_BITS = 0x3FE6A09E667F3BCD
_FROM_SQRT_HALF = 0x3FF0000000000000 - _SQRT_HALF_BITS  # added to a bit pattern, a mantissa from √½ counts in the next exponent
_MANTISSA = 0x000FFFFFFFFFFFFF
_POSITIVE = 0x7FFFFFFFFFFFFFFF
_TWO_52 = 0x4330000000000000  # 2**52: an integer below 2**52 in its low bits is added to it
_LOG2_E = 1.4426950408889634
_ROUND = 6755399441055744.0  # 1.5 * 2**52: adding it rounds a double to an integer held in its low bits
_ROUND_BITS = 0x4338000000000000


@kernel
def log2(x):
    """Base-2 logarithm of a normal positive double; error ≤ 2 ε of max(|log2 x|, 0.5 |log2 m|), m the mantissa.

    x = m 2^k with m in [√½, √2); ln m = 2 atanh z, z = (m-1)/(m+1), by a Chebyshev polynomial in z² (2e-18).
    """
    # AVX2 has neither an arithmetic shift nor a conversion of 64-bit integers
    pattern = (bits(x) + _FROM_SQRT_HALF) & _POSITIVE
    exponent = from_bits((pattern >> 52) | _TWO_52) - (4503599627370496.0 + 1023.0)
    m = from_bits((pattern & _MANTISSA) + _SQRT_HALF_BITS)
    z = (m - 1.0) / (m + 1.0)
    w = z * z
    w2 = w * w
    # Estrin's scheme: a shorter chain of dependent operations than Horner's
    tail = 0.1818363182295751 + w * 0.1531252432604664 + w2 * 0.14809750333398877
    tail = (0.6666666666666765 + w * 0.39999999999302227) + w2 * (0.2857142876066624 + w * 0.2222219705410192) + w2 * w2 * tail
    tail *= w
    return exponent + (2.0 * z + z * tail) * _LOG2_E


@kernel
def exp2(x):
    """2^x; error ≤ 1 ε for -1020 ≤ x < 1023. Below, x counts as -1020."""
    x = x if x > -1020.0 else -1020.0
    rounded = x + _ROUND
    fraction = x - (rounded - _ROUND)
    f2 = fraction * fraction
    f4 = f2 * f2
    a = (0.6931471805599453 + fraction * 0.24022650695910158) + f2 * (0.055504108664821625 + fraction * 0.009618129107587256)
    b = (0.001333355814640647 + fraction * 0.00015403530463724353) + f2 * (
        1.5252733841556773e-05 + fraction * 1.3215432535912375e-06
    )
    c = (1.0178057087733941e-07 + fraction * 7.074194297288521e-09) + f2 * 4.4558179083360645e-10
    y = 1.0 + fraction * (a + f4 * (b + f4 * c))
    return y * from_bits((bits(rounded) - _ROUND_BITS + 1023) << 52)


@kernel
def power(x, exponent):
    """x^exponent for 0 ≤ x ≤ 1e300 and 0 < exponent < 3.4; error ≤ (1 + |exponent ln x|) ε.

    Below 1e-300, x counts as 1e-300. The result for NaN or infinity is not defined: the caller sorts those out.
    """
    return exp2(exponent * log2(x if x > 1e-300 else 1e-300))


@kernel
def cbrt(x):
    """Cube root of x ≥ 0; error ≤ 1 ε, exact 0 at 0.

    y ≈ x^(-1/3) from a third of the exponent bits, two steps of a fourth-order iteration without division, then
    one Newton correction of x y².
    """
    # a third of the upper half of the bits, times 2^32/3: AVX2 has no integer division and no product of 64-bit integers
    y = from_bits((0x553EF0FF - (((bits(x) >> 32) & 0x7FFFFFFF) * 1431655766 >> 32)) << 32)
    h = 1.0 - x * y * y * y
    y += y * h * (1.0 / 3.0 + h * (2.0 / 9.0 + h * (14.0 / 81.0)))
    h = 1.0 - x * y * y * y
    y += y * h * (1.0 / 3.0 + h * (2.0 / 9.0 + h * (14.0 / 81.0)))
    root = x * y * y
    # halves: of the largest double the cube itself would overflow unless it is fused with the difference
    root -= (root * root * (0.5 * root) - 0.5 * x) * (y * y) * (2.0 / 3.0)
    return root if x - x == 0.0 else x


def root_finder(curve):
    """Kernel that finds where a rising `curve`(p, x) → (value, derivative) has a value, by Newton's method inside a bracket.

    low, high: bracket; x: where it begins; it ends when a step is at most `tolerance` of x.
    """

    @kernel
    def find(p, value, low, high, x, tolerance):
        for _ in range(200):
            there, slope = curve(p, x)
            if there > value:
                high = x
            else:
                low = x
            new = x - (there - value) / slope if slope > 0.0 else 0.5 * (low + high)
            if not (low <= new <= high):
                new = 0.5 * (low + high)
            last = abs(new - x) <= tolerance * new
            x = new
            if last:
                break
        return x

    return find


# --- Hertz's smooth sphere: all Params hold its coefficient


@kernel
def hertz_coefficient(radius, modulus):
    """(4/3) E* √R [N/m^1.5]."""
    return 4.0 * modulus * sqrt(radius) / 3.0


@kernel
def hertz_overlap(p, force):
    """δ_H(P) = (9 P²/(16 R E*²))^(1/3) [m] of any law's params."""
    root = cbrt(force / p.hertz_coefficient)
    return root * root
