"""Contacts for ParaView, with quantities that VTKRecorder does not have, since it reads YADE's own classes only."""

import numpy as np
import yade

from demlaws.files import as_path, write_atomically

QUANTITIES = (
    "force",
    "stiffness",
    "overlap",
    "maximum_overlap",
    "plastic_overlap",
    "radius_ratio",
    "branch",
    "stored",
    "dissipated",
    "roughness",
)


def write_contacts(path, state):
    """Write a `ContactState` of the current scene to a legacy .vtk file: for each contact a line between its bodies.

    A quantity that the law's unloading rule does not have is NaN; in a periodic scene the second end is the image that is met.
    Returns the path.
    """
    path = as_path(path)
    bodies, contacts = yade.O.bodies, yade.O.interactions
    ends = np.empty((len(state.body1), 2, 3))
    for n, (first, second) in enumerate(zip(state.body1.tolist(), state.body2.tolist(), strict=True)):
        ends[n] = bodies[first].state.pos, bodies[second].state.pos
        if yade.O.periodic:
            ends[n, 1] += np.array(yade.O.cell.hSize * yade.Vector3(*map(float, contacts[first, second].cellDist)))
    lines = [
        "# vtk DataFile Version 3.0",
        f"demlaws contacts at step {yade.O.iter}, t = {yade.O.time:g} s, SI units",
        "ASCII",
        "DATASET POLYDATA",
        f"POINTS {2 * len(ends)} double",
        *(" ".join(f"{x:.17g}" for x in point) for point in ends.reshape(-1, 3)),
        f"LINES {len(ends)} {3 * len(ends)}",
        *(f"2 {2 * n} {2 * n + 1}" for n in range(len(ends))),
        f"CELL_DATA {len(ends)}",
    ]
    for name in QUANTITIES:
        lines += [f"SCALARS {name} double 1", "LOOKUP_TABLE default", *(f"{x:.17g}" for x in getattr(state, name).tolist())]
    write_atomically(path, "\n".join(lines) + "\n")
    return path
