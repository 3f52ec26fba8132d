"""Energy that friction and partial slip take from small waves, in LAMMPS without viscous damping; rows in `attenuation.csv`.

- cycle: a packing is compressed along z with friction to each pressure, and strained to and fro there. share: area of the
  second loop of stress over strain, over the largest elastic energy ½ M ε². dissipated: energy that the contacts lose,
  over ½ M ε² V; they also lose energy that they had stored before. With rule hertz asperities stay flattened.
- pulse: a pulse in a column of packings at rest without shear forces, as in the case `waves`. share: energy dissipated
  on the way from NEAR to FAR over the energy of the pulse.
- `slip` has the 11 springs of the engines, or those that the kind names.

The amplitude of a wave of frequency f and speed c falls by exp(-α x) with α = share f/(2 c) (cycle), share/(2 x) (pulse).
"""

import itertools
import tempfile
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.files import csv_text
from demlaws.lammps import run
from demlaws.lammps.run import HEAD
from demlaws.laws import HERTZ, POHRT_POPOV
from studies.assembly.report import spread
from studies.assembly.stiffness import moduli
from studies.assembly.study import BEADS, HERE, START, STORE, Series, append, begin, read, smooth
from studies.paired import interval, pooled
from studies.trade.liggghts_oedometer import data_text

RESULTS = HERE / "attenuation.csv"
PRESSURES = (10e3, 20e3, 50e3, 100e3)
STRAINS = (1e-6, 1e-5)
SPEEDS = (0.5e-3, 5e-3)
"""Amplitudes of the strain of a cycle, and of the velocity of a pulse at the start [m/s]."""
COUNT, BOXES = 400, 10  # spheres of a packing, packings in the column
WIDTH, LAYER, NEAR, FAR = 5e-3, 1e-3, 10e-3, 22e-3  # [m] of the pulse
PERIOD, REST = 3000, 8000  # steps
SHEAR = {"default": "", "slip": " shear slip"}
AXES = {"z": "z", "x": "xz"}
"""Polarisation of the wave → axis of fix deform."""
FIELDS = (
    "kind",
    "law",
    "sigma_um",
    "shear",
    "seed",
    "rule",
    "kPa",
    "axis",
    "amplitude",
    "modulus_MPa",
    "speed",
    "share",
    "dissipated",
    "height",
    "steps",
)

GROUND = """\
boundary        p p p
newton          on
read_data       start.data
{column}
neighbor        5e-5 bin
neigh_modify    delay 0
pair_style      granular
pair_coeff      * * demlaws/table pair.tbl {young:.10g} 0 {poisson}{words} tangential demlaws 0 {friction:g} damping velocity
timestep        {dt:.10g}
fix             move all nve/sphere
"""
BEGIN = """\
compute         press all pressure NULL virial
variable        z equal c_press[3]
variable        xz equal c_press[5]
variable        phase equal 0
variable        angle equal 0
variable        lost equal 0
thermo_style    custom step v_phase v_angle v_z v_xz vol v_lost
thermo_modify   norm no lost error format float %.17g
thermo          1000
"""
DRAG = "fix             drag all viscous {drag:.10g}\nfix             turn all viscous/sphere {turn:.10g}\n"
COMPRESS = """\
fix             strain all deform 1 z erate {rate:.10g} units box remap v
fix             there all halt 20 v_z > {pressure:.10g} error continue
run             200000
unfix           there
unfix           strain
run             {rest}
"""
CYCLES = """\
variable        phase equal {phase}
variable        size equal $(-{strain:.10g}*lz)
variable        turn equal $(2*PI/{period})
variable        begun equal $(step)
variable        angle equal v_turn*(step-v_begun)
variable        way equal v_size*(1-cos(v_angle))
variable        rate equal v_size*v_turn/dt*sin(v_angle)
fix             strain all deform 1 {axis} variable v_way v_rate remap v
thermo          {every}
run             {steps}
unfix           strain
variable        phase equal 0
thermo          1000
run             1000
"""
ENERGY = "compute         energy all demlaws/energy\nvariable        lost equal c_energy[2]\nrun             0\n"
PULSE = """\
variable        pulse atom {amplitude:.10g}/exp(((z-0.5*lz)/{width})^2)
variable        none atom 0
velocity        all set {velocity}
compute         layers all chunk/atom bin/1d z lower {layer} units box
fix             motion all ave/chunk 1 1 1 layers v{axis} norm sample file post/motion.txt
compute         moves all ke
compute         energy all demlaws/energy
variable        lost equal c_energy[2]
thermo_style    custom step dt c_moves v_lost
thermo_modify   norm no lost error format float %.17g
thermo          1
run             {steps}
"""


class Model(NamedTuple):
    """Law, combined roughness [µm], shear model, packing, unloading rule."""

    law: str = HERTZ
    sigma: float = 0.0
    shear: str = "default"
    seed: int = 1
    rule: str = "elastic"

    def series(self, count):
        """`Series` of the packing."""
        return Series(law=self.law, sigma=self.sigma, count=count, seed=self.seed)

    def frequency(self, pressure):
        """√(K/m) [1/s] of contacts of ten times the mean force, K after a reversal."""
        series = self.series(COUNT)
        law, bead = series.bound() if self.rule == "elastic" else smooth(series), BEADS[series.bead]
        return float(np.sqrt(law.stiffness(law.overlap(10.0 * pressure * bead.diameter**2)) / bead.mass))


MODELS = tuple(Model(*law, shear) for shear in SHEAR for law in ((HERTZ, 0.0), (POHRT_POPOV, 0.5)))
FLATTENED = tuple(Model(POHRT_POPOV, 0.5, shear, rule=HERTZ) for shear in SHEAR)
"""Cycles alone: contacts of a packing at rest are on first loading, so that a pulse flattens them."""


def ground(folder, model, packing, frequency, column, step, springs):
    """Write table and data of a packing; input up to the motion, with steps of `step`/frequency."""
    bead = packing.bead
    (folder / "post").mkdir()
    packing.law.joined(model.rule).tabulate(rtol=1e-7).save(folder / "pair.tbl")
    atoms = [(1, bead.diameter, bead.density, *place) for place in packing.bodies[0]]
    (folder / "start.data").write_text(data_text([(0.0, side) for side in packing.size], atoms, types=1))
    about = {"young": bead.young, "poisson": bead.poisson, "friction": bead.friction, "words": SHEAR[model.shear]}
    if springs is not None:
        about["words"] += f" springs {springs}"
    return HEAD + GROUND.format(column=column, dt=step / frequency, **about)


def cycles(model, store=STORE, count=COUNT, pressures=PRESSURES, strains=STRAINS, period=PERIOD, step=0.2, springs=None):
    """Rows of `cycle`; the drag is 0.03 m √(K/m) in compression, a tenth of it in cycles, where it takes less than 1 %."""
    packing, keys = begin(model.series(count), store), []
    packing.compress([START] * 3)
    bead, frequency = packing.bead, model.frequency(pressures[-1])

    def drag(part):
        return DRAG.format(drag=part * bead.mass * frequency, turn=0.1 * part * bead.mass * frequency * bead.diameter**2)

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = ground(folder, model, packing, frequency, "change_box      all triclinic", step, springs) + BEGIN
        for pressure in pressures:
            rate = -2e-4 / bead.diameter * np.sqrt(pressure / bead.density)
            text += drag(0.03) + COMPRESS.format(rate=rate, pressure=pressure, rest=REST) + ENERGY * (not keys) + drag(0.003)
            for strain, (axis, side) in ((strain, pair) for strain in strains for pair in AXES.items()):
                keys.append((pressure, axis, strain))
                values = {"axis": side, "period": period, "steps": 2 * period, "every": period // 100}
                text += CYCLES.format(phase=len(keys), strain=strain, **values)
        (folder / "in.cycles").write_text(text)
        log = run(folder / "in.cycles")
    for number, (pressure, axis, strain) in enumerate(keys, start=1):
        rows = np.flatnonzero(log["phase"] == number)
        last = rows[log["angle"][rows] > 1.999 * np.pi]
        turn = log["angle"][last] - 2.0 * np.pi / period  # a step's box has the strain of the step before
        shapes = np.stack([np.cos(turn), np.sin(turn), turn, np.ones(len(turn))], axis=1)  # with a drift
        inside, outside, *_ = np.linalg.lstsq(shapes, log[AXES[axis]][last], rcond=None)[0]
        volume = log["Volume"][last].mean()
        modulus, lost = abs(inside) / strain, log["lost"][last[-1]] - log["lost"][last[0]]
        speed = np.sqrt(modulus * volume / (count * bead.mass))
        shares = -2.0 * np.pi * outside / inside, 2.0 * lost / (modulus * strain**2 * volume)
        yield row("cycle", model, pressure, axis, strain, modulus, speed, *shares, log)


def row(kind, model, pressure, axis, amplitude, modulus, speed, share, dissipated, log, height=np.nan):
    """A row (dict)."""
    wave = (1e-3 * pressure, axis, amplitude, 1e-6 * modulus, speed, share, dissipated, height)
    return dict(zip(FIELDS, (kind, *model, *wave, int(log["Step"][-1])), strict=True))


def at_rest(model, pressure, store=STORE, count=COUNT):
    """A packing in isotropic compression without shear forces, its forces in balance to rounding."""
    packing = begin(model.series(count), store)
    packing.friction = 0.0
    packing.compress([pressure] * 3, balance=1e-4)
    frequency = np.sqrt(packing.results[5] / packing.bead.mass)
    packing.friction, packing.contacts[:, :3] = 1e9, 0.0
    packing.run(20_000, [0.0] * 3, 0.0, 0.0, 0.1 * frequency, 0.3 / frequency)
    return packing


def pulse(model, packing, pressure, axis, amplitude, step=0.2, springs=None):
    """A row of `pulse`."""
    found = moduli(packing.carrying(), packing.size, packing.bead.shear_ratio)
    modulus = found.along if axis == "z" else found.across
    speed = np.sqrt(modulus / (packing.solid * packing.bead.density))
    frequency = np.sqrt(packing.results[5] / packing.bead.mass)
    steps = round(1.3 * FAR / speed * frequency / step)
    velocity = "v_none v_none v_pulse" if axis == "z" else "v_pulse v_none v_none"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = ground(folder, model, packing, frequency, f"replicate       1 1 {BOXES}", step, springs)
        values = {"width": WIDTH, "layer": LAYER, "axis": axis, "steps": steps, "velocity": velocity}
        (folder / "in.pulse").write_text(text + PULSE.format(amplitude=amplitude, **values))
        log = run(folder / "in.pulse")
        lines = [line.split() for line in (folder / "post" / "motion.txt").read_text().splitlines() if line[0] != "#"]
    cells = np.array([line for line in lines if len(line) == 4], float).reshape(-1, int(lines[0][1]), 4)
    places, velocities = cells[0, :, 1] - 0.5 * (cells[0, 0, 1] + cells[0, -1, 1]), cells[:, :, 3]
    near, far = (
        np.mean([[np.interp(side * place, places, v) for v in velocities] for side in (-1, 1)], axis=0) for place in (NEAR, FAR)
    )
    first, last = (np.argmax(signal) for signal in (near, far))
    share = (log["lost"][last] - log["lost"][first]) / log["moves"][0]
    flight = (FAR - NEAR) / ((last - first) * log["Dt"][0])
    return row("pulse", model, pressure, axis, amplitude, modulus, flight, share, share, log, far.max() / near.max())


def pulses(model, store=STORE, pressures=PRESSURES, speeds=SPEEDS, axes=AXES, **settings):
    """Rows of `pulse`."""
    for pressure in pressures:
        packing = at_rest(model, pressure, store)
        for axis in axes:
            for amplitude in speeds:
                yield pulse(model, packing, pressure, axis, amplitude, **settings)


LOWEST = {"pressures": PRESSURES[:1]}
SETTINGS = {
    "pulse, half the step": {"step": 0.1, "speeds": SPEEDS[1:], "axes": "z", **LOWEST},
    "pulse, 22 springs": {"springs": 22},
    "cycle, half the step": {"step": 0.1, "period": 2 * PERIOD, **LOWEST},
    "cycle, half the speed": {"period": 2 * PERIOD, **LOWEST},
    "cycle, 22 springs": {"springs": 22, **LOWEST},
}


def sensitive(kind, model, store=STORE):
    """Rows with other settings."""
    waves = pulses if kind.startswith("pulse") else cycles
    return [one | {"kind": kind} for one in waves(model, store, **SETTINGS[kind])]


def run_waves(path=RESULTS, store=STORE, seeds=2, progress=print):
    """Rows that `path` lacks; settings of a packing with `slip`, last."""
    waves = itertools.product(range(1, seeds + 1), (("cycle", (*MODELS, *FLATTENED)), ("pulse", MODELS)))
    wanted = [(kind, model._replace(seed=seed)) for seed, (kind, models) in waves for model in models]
    wanted += [(kind, Model(shear="slip")) for kind in SETTINGS]
    wanted += [(kind, FLATTENED[1]) for kind in SETTINGS if kind.startswith("cycle")]
    done = {tuple(line[name] for name in ("kind", *FIELDS[1:6])) for line in read(path)}
    for kind, model in wanted:
        if (kind, *model) not in done:
            rows = {"cycle": cycles, "pulse": pulses}.get(kind, partial(sensitive, kind))
            append(path, FIELDS, list(rows(model, store)))
            progress(f"{kind} {' '.join(map(str, model))}")


def exponents(lines):
    """Exponents over pressure of α at one frequency (cycle) or of one pulse, of each packing.

    NaN: the loop of a cycle is too narrow to be measured.
    """
    found = []
    for seed in sorted({line["seed"] for line in lines}):
        chosen = [line for line in lines if line["seed"] == seed]
        alpha = [line["share"] / (line["speed"] if line["kind"].startswith("cycle") else 1.0) for line in chosen]
        pressures = np.log([line["kPa"] for line in chosen])
        found.append(np.polyfit(pressures, np.log(alpha), 1)[0] if min(alpha) > 0.0 else np.nan)
    return found


def exponent(lines):
    """Mean and standard deviation of `exponents`."""
    return spread(exponents(lines))


MEASURED = -0.1879
"""Exponent of the attenuation of glass beads (docs/validation/small-strain.md)."""


def intervals(found):
    """Wave → `Estimate` of its exponent against `MEASURED`.

    The scatter of packings is pooled over the waves of its motion and amplitude; a wave with one packing has no other.

    found: wave (values of WAVE) → its rows; rows at one pressure have no exponent.
    """
    values = {wave: exponents(lines) for wave, lines in found.items() if len({line["kPa"] for line in lines}) > 1}
    values = {wave: some for wave, some in values.items() if not np.isnan(some).any()}
    alike = {wave: (wave[0].split(",")[0], wave[-1]) for wave in values}
    scatter = {key: pooled(values[wave] for wave in values if alike[wave] == key) for key in set(alike.values())}
    return {wave: interval(some, *scatter[alike[wave]], expected=MEASURED) for wave, some in values.items()}


WAVE = ("kind", "law", "sigma_um", "shear", "rule", "axis", "amplitude")


def table(path=RESULTS):
    """CSV text: a line per wave of each model: shares (means of the packings), exponent of α, steps of a run; settings last."""
    found, pressures = {}, [1e-3 * pressure for pressure in PRESSURES]
    for row in sorted(read(path), key=lambda row: (row["kind"] in SETTINGS, row["kind"])):
        found.setdefault(tuple(row[name] for name in WAVE), []).append(row)
    heads = [
        "motion",
        *WAVE[1:5],
        "wave",
        "amplitude",
        "seeds",
        *(f"share, {p:g} kPa" for p in pressures),
        "exponent",
        "95 %",
        "steps",
    ]
    lines, estimates = [], intervals(found)
    for (kind, law, sigma, *rest, axis, amplitude), some in found.items():
        shares = [[row["share"] for row in some if row["kPa"] == p] for p in pressures]
        mean, off = exponent(some) if all(shares) else (np.nan, np.nan)
        cells = [kind, law, f"{sigma:g}", *rest, "longitudinal" if axis == "z" else "transverse", f"{amplitude:g}"]
        cells += [str(len({row["seed"] for row in some})), *(f"{np.mean(share):.3g}" if share else "" for share in shares)]
        estimate = estimates.get((kind, law, sigma, *rest, axis, amplitude))
        cells += [
            ("" if np.isnan(mean) else f"{mean:+.2f}") + ("" if np.isnan(off) else f" ± {off:.2f}"),
            "" if estimate is None else f"{estimate.low:+.2f} to {estimate.high:+.2f}",
            f"{some[-1]['steps']:.0f}",
        ]
        lines.append(cells)
    return csv_text(heads, lines)
