// demlaws_table.h: contact-law tables of demlaws for any DEM code. C++11, with the headers beside it that it
// includes, no other dependency.
//
// A table file (written by `demlaws table`) is a normal contact law without units:
//     u = overlap / length,   s(u) = Hertz-equivalent overlap / length,
//     force P = (4/3) E* sqrt(R) S^1.5 with S = s length,   tangent stiffness K = 2 E* sqrt(R S) ds/du.
// With `unloading: table` the file holds a second curve of the same kind, which a contact unloads along.
// One table serves every pair of radii and moduli of a law that collapses; length comes from the roughness.
// docs/inside/table-format.md has the grammar of the file, and what holds below its first row and beyond its last.
//
//     demlaws::Table table("granite.tbl");                        // throws std::runtime_error that names file and line
//     demlaws::Pair pair(table, modulus, roughness);              // E* in Pa, combined rms roughness in m
//     demlaws::State state;                                       // zeros: before first loading; keep one for each
//     contact demlaws::Force now = demlaws::step(pair, radius, overlap, state); if (now.outside) ... // overlap beyond
//     the last row: no certified value
//
// docs/how-to/own-code.md: a complete contact, MPI, restart.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_TABLE_H
#define DEMLAWS_TABLE_H
#include "demlaws_contact.h" // Pair, step, energies
#include "demlaws_curve.h"   // the curve
#include "demlaws_reader.h"  // Table: the file
#endif
