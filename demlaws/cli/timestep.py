"""`demlaws timestep`: the largest stable step of the contacts of a dump."""

from demlaws.cli import example
from demlaws.cli.arguments import density, plain
from demlaws.cli.contact import add_dump_arguments, bodies_from, law_from
from demlaws.errors import DemlawsError, counted


def register(add):
    """Add this command."""
    parser = add(
        description="Computes the largest stable time step of the last frame of a dump, 2/ω_max with shear and rotation, "
        "Rayleigh's step and the recommended step. GRAINS is a dump of the grains of LIGGGHTS or LAMMPS, CONTACTS the local "
        "dump of their contacts. Dumps have no stiffness: give the law and the contact without radii. For a law whose "
        "unloading depends on the largest overlap of each contact, CONTACTS must have it (exported cases do). No contact is "
        "assumed to slide. Contacts with walls are not in these dumps.",
        **example(
            "  demlaws timestep post/grains.5000.txt post/contacts.5000.txt --law pohrt-popov --unloading hertz \\\n"
            "      --young 60.6GPa --poisson 0.25 --roughness 1.7um --fractal-dimension 2.22"
        ),
    )
    parser.add_argument("--no-rotation", action="store_true", help="the grains do not rotate")
    parser.add_argument(
        "--shear-ratio", type=plain, help="K_t/K, at most 4/3, 0 without friction (default: from ν, otherwise 1)"
    )
    parser.add_argument("--undamped", action="store_true", help="nothing dissipates energy: lossless bodies that bounce")
    parser.add_argument(
        "--density",
        type=density,
        help="density in kg/m³ if the dump contains no mass or density (default: that of --material, otherwise 2680)",
    )
    add_dump_arguments(parser)


def run(arguments, result):
    """Do what the command's arguments ask."""
    import numpy as np

    from demlaws.cli.dumps import read_dumps, stiffness_of
    from demlaws.contact import DENSITY
    from demlaws.timestep import STEP_SAFETY, UNDAMPED_SAFETY, from_contacts

    if arguments.law is None:
        raise DemlawsError("give the law of the contacts: --law with the contact's quantities")
    dumped = read_dumps(arguments)
    atoms, pairs = dumped.atoms, dumped.pairs
    _refuse_clumps(arguments.snapshot, atoms)
    if not len(pairs):
        raise DemlawsError(f"{arguments.contacts}: no contact in it carries a force")
    volume = 4.0 / 3.0 * np.pi * atoms["radius"] ** 3
    grain = (bodies_from(arguments) or [None])[0]
    density = arguments.density or (grain and grain.density) or DENSITY
    mass = atoms["mass"] if "mass" in atoms else volume * atoms.get("density", density)
    ratio, rayleigh = _ratio_and_rayleigh(arguments, grain, set(zip(atoms["radius"], mass / volume, strict=True)))
    arguments.effective_radius = dumped.radius
    stiffness = stiffness_of(arguments.contacts, dumped, law_from(arguments))
    blocked = np.zeros((len(mass), 6), bool)
    blocked[:, 3:] = arguments.no_rotation
    normals = dumped.between / np.linalg.norm(dumped.between, axis=1)[:, None]
    limit = from_contacts(pairs, normals, stiffness, shear_stiffness=ratio * stiffness, masses=mass, blocked=blocked)
    motion = "with shear and rotation" if ratio else "without friction"
    if ratio and arguments.no_rotation:
        motion = "with shear, without rotation"
    counts = f"{counted(len(pairs), 'contact')}, {counted(len(mass), 'grain')}"
    result.print(f"{counts}, {2 * len(pairs) / len(mass):.3g} contacts per grain")
    result.print(f"exact limit       {limit:.4g} s  2/ω_max {motion}, contacts between grains")
    if rayleigh is not None:
        result.print(f"Rayleigh step     {rayleigh:.4g} s  {rayleigh / limit:.2f} of the exact limit, for comparison")
    safety = UNDAMPED_SAFETY if arguments.undamped else STEP_SAFETY
    step = safety * limit
    result.print(f"recommended step  {step:.4g} s  {safety:g} of the exact limit; less if loads still grow")
    result.values = {"contacts": len(pairs), "grains": len(mass), "exact": limit, "rayleigh": rayleigh}
    result.values |= {"recommended": step, "motion": motion}


def _refuse_clumps(path, atoms):
    """Raise where grains are members of rigid clumps: their mass and inertia are those of the clump, which no dump contains."""
    import numpy as np
    from scipy.spatial import cKDTree

    molecules = atoms.get("mol", np.zeros(0))
    clumped = np.max(np.unique(molecules[molecules > 0.0], return_counts=True)[1], initial=0) > 1
    if len(atoms["id"]) > 1:
        centres = np.stack([atoms[axis] for axis in "xyz"], axis=1)
        distance, nearest = cKDTree(centres).query(centres, k=2)
        clumped |= np.any(distance[:, 1] < 0.7 * (atoms["radius"] + atoms["radius"][nearest[:, 1]]))
    if clumped:
        raise DemlawsError(
            f"{path}: grains that have the same mol, or overlap by more than 0.3 of their radii, are members of a clump, which "
            "moves as one body, whose mass and inertia the dump does not contain: the limit cannot be computed; dump no mol if "
            "each moves by itself"
        )


def _ratio_and_rayleigh(arguments, grain, kinds):
    """K_t/K, and the smallest Rayleigh step [s] of `kinds`, (radius, density), or None; grain: the material, or None."""
    from demlaws.core.shear import LARGEST_SHEAR_RATIO
    from demlaws.timestep import rayleigh_step, shear_ratio
    from demlaws.units import number

    ratio, rayleigh = 1.0, None
    if grain is not None:
        ratio = shear_ratio(grain, grain)
        rayleigh = min(rayleigh_step(r, density, grain.young, poisson=grain.poisson) for r, density in kinds)
    if arguments.shear_ratio is not None:
        ratio = number(arguments.shear_ratio, "--shear-ratio", "", 0.0, LARGEST_SHEAR_RATIO, allow_low=True)
    return ratio, rayleigh
