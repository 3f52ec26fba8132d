"""TEMPORARY until Table.save lands."""
import math, zlib
import numpy as np
from demlaws.files import write_atomically

def save_table(law, path, rtol=1e-5, range_overlap=None):
    bits = 5 if rtol > 1e-8 else 9
    sigma = float(law.contact.roughness) or 1e-6
    lo, hi = 1e-5, 300.0
    u = (np.arange(np.float64(lo).view(np.int64) >> (52 - bits), (np.float64(hi).view(np.int64) >> (52 - bits)) + 2) << (52 - bits)).astype(np.int64).view(np.float64)
    E, R = law.contact.modulus, law.contact.radius
    c = E * math.sqrt(R) * sigma**1.5
    import warnings
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        f, k = law.force(u * sigma) / c, law.stiffness(u * sigma) * sigma / c
        rows = list(zip(u, f, k))
        kinks = []
        if hasattr(law.shape, "kappa"):
            x = law.shape.kappa * law.shape.ratio
            kinks = [x]
            fx = 4 / 3 * law.shape.kappa**1.5
            kx = 2 * math.sqrt(law.shape.kappa)
            rows += [(x, fx, kx), (x, fx, kx * (1 + 1e-16))]
            rows.sort(key=lambda r: r[0])
    lines = [f"law: {law.name}", f"unloading: {law.unloading}", "options: {}", "length_over_roughness: 1.0", f"bits: {bits}", "kinks: " + " ".join(map(repr, kinks)), f"length: {sigma!r}", f"rows: {len(rows)}", "overlap force stiffness"]
    lines += ["%.17g %.17g %.17g" % r for r in rows] + [f"end: {len(rows)} rows"]
    out = ["# demlaws-table 1\n"]
    crc = zlib.crc32(out[0].encode())
    for line in lines:
        crc = zlib.crc32(line.encode(), crc)
        tail = " %08x" % crc
        out.append(line + tail + "\n")
        crc = zlib.crc32((tail + "\n").encode(), crc)
    write_atomically(path, "".join(out))
    return path
