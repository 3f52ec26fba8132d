"""The public interface of a law, made of a curve of first loading and an unloading rule; tables of laws and their files."""

import dataclasses
import functools
import math
import os
from collections.abc import Callable
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from demlaws.contact import Contact, as_contact
from demlaws.core.loops import equal_params, loading_part, params_at
from demlaws.core.unloading import GIVEN
from demlaws.curves.closed import FormulaCurve
from demlaws.curves.unloading import ELASTIC, Unloading, beside_table, refuse_unless_passive
from demlaws.errors import DemlawsError, NotPassive
from demlaws.files import names_a_file, write_atomically
from demlaws.laws.definition import HERTZ_CURVE
from demlaws.responses.response import Response
from demlaws.units import as_given, as_typed, number

if TYPE_CHECKING:
    from demlaws.core.grid import Nodes
    from demlaws.curves.branch import Measured
    from demlaws.curves.points import Knots
    from demlaws.curves.table import TableCurve


class Law(Response):
    """A curve of first loading on a contact, joined with an unloading rule. Made by `demlaws.law(...)`.

    Overlaps in m, forces in N, stiffnesses in N/m, energies in J. The methods take a number or an array and return the
    same; with a contact that is an array of contacts, arrays have one entry per contact, and a number, too, returns an array
    (a type checker expects a number there: give `np.full(n, overlap)`).

    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> print(f"{law.force(1e-6):.4f} N, {law.stiffness(1e-6):.0f} N/m, {law.overlap(10.0) * 1e6:.3f} µm")
    2.6985 N, 4047715 N/m, 2.395 µm
    >>> batch = dl.law("hertz", dl.Contact(radius=[1e-3, 4e-3], modulus=32e9), unloading="hertz")
    >>> state = batch.new_state(2)
    >>> force, stiffness = batch.evaluate([1e-6, 1e-6], state)
    >>> force.round(4), state.maximum_overlap
    (array([1.3492, 2.6985]), array([1.e-06, 1.e-06]))
    """

    def __repr__(self):
        options = "".join(f", {k}={v!r}" for k, v in self.options.items())
        unloading = self.unloading if self.unloading_law is None else self.unloading_law
        return f"demlaws.law({self.name!r}, {self.contact!r}, unloading={unloading!r}{options})"

    def __eq__(self, other: object) -> bool:
        """Whether both have the same curve, unloading rule, options and contact."""
        if not isinstance(other, Law):
            return NotImplemented
        same_kind = type(self) is type(other) and self.definition is other.definition
        return (
            same_kind
            and self.unloading == other.unloading
            and self.contact == other.contact
            and equal_params((self.shape, self.params), (other.shape, other.params))
        )

    def __hash__(self) -> int:
        return hash((self.name, self.unloading))

    # --- parts

    measured: "Measured | None" = None
    """The points that the law was fitted to: their noise allows changes of an unloading curve."""

    @functools.cached_property
    def unloading_law(self) -> "Law | None":
        """The law along whose curve the contact unloads (rule "table"), or None."""
        parts = self.unloading_parts
        return None if parts.curve is None or parts.contact is None else composed(parts.contact, parts.curve)

    @property
    def force_error(self) -> float:
        """Largest relative error of the force: 0 in closed form, of a table that of its certificate."""
        return self.curve.certificate.force_error

    @property
    def stiffness_error(self) -> float:
        """Largest relative error of the stiffness."""
        return self.curve.certificate.stiffness_error

    @property
    def largest_force(self) -> float:
        """Force [N] at the end of the curve: infinite in closed form."""
        return self.curve.largest_force(loading_part(self.params))

    @property
    def largest_overlap(self) -> float:
        """End of the curve [m]: infinite in closed form."""
        return float(np.min(self.curve.end(loading_part(self.params))))

    @property
    def collapses(self) -> bool:
        """Whether one dimensionless curve (with a given unloading curve: one pair of curves) serves all contacts."""
        other = self.unloading_parts.curve
        if other is None or not self.curve.collapses:
            return self.curve.collapses
        # Hertz's curve has no length of its own
        return other.collapses and (
            other.definition.loading.computed == HERTZ_CURVE or other.definition.length == self.definition.length
        )

    def kinks(self) -> list[float]:
        """Overlaps [m] at which the stiffness of first loading (of the first contact) jumps or has a kink."""
        return self.curve.kinks(params_at(loading_part(self.params), 0))

    def joined(self, unloading: "str | os.PathLike | Law") -> "Law":
        """The same law of first loading with another unloading rule.

        Parameters
        ----------
        unloading : str or Law
            Name of a rule, or the law, `Table` or table file along whose curve the contact unloads.

        Returns
        -------
        Law

        Raises
        ------
        DemlawsError
            If a load cycle could return more work than was done on the contact.
        """
        return join(self.contact, self.curve, unloading)

    def bound_to(self, contact: Contact, surface_matters: bool = True) -> "Law":
        """The same law and options for another contact, elastic.

        Parameters
        ----------
        contact : Contact
            One contact or an array of contacts.
        surface_matters : bool
            Of a table: False where it is an unloading curve, for which only radius, modulus and roughness must agree.

        Returns
        -------
        Law
        """
        return Law(as_contact(contact), FormulaCurve(self.definition, contact, self.options))

    def overlap_of(self, max_force: float | str) -> Any:
        """`overlap` at a force that the user typed as max_force [N], which an error names."""
        return as_given(self._overlap(number(max_force, "max_force", "N"), max_force, "max_force"))

    def tabulate(self, rtol: float = 1e-5, max_force: float | None = None) -> "Table":
        """The smallest `Table` of this law whose force and stiffness lie within `rtol`, measured between the nodes.

        Parameters
        ----------
        rtol : float
            Largest relative error of force and stiffness.
        max_force : float, optional
            Force [N] at which the table ends. Default: the force at an overlap of R/10. If the law has a single dimensionless
            curve, the table is valid for every R, E* and σ and ends at an overlap equal to R.

        Returns
        -------
        Table
            Below its first row the law is a power law to within `rtol`.
        """
        from demlaws.curves.tabulate import tabulate, tolerance

        tolerance(rtol)
        if self.contact.size is not None and not self.collapses:
            raise DemlawsError(
                f"law {self.name!r} has no single dimensionless curve for contacts that differ: tabulate each kind of contact"
            )
        largest = None if max_force is None else self.overlap_of(max_force)
        curve = tabulate(self.contact, self.curve, rtol, largest)
        return Table(self.contact, curve, _adapted(self.unloading_parts, self.contact, curve))


def as_law(value: Any) -> Law:
    """The value, or a DemlawsError if it is not a law."""
    if not isinstance(value, Law):
        raise DemlawsError(f"law must be a demlaws law or table (dl.law, dl.Table.load), got {value!r:.60}")
    return value


# --- composition


def composed(contact: Contact, curve: "FormulaCurve | TableCurve", unloading: Unloading = ELASTIC) -> Law:
    """The law of these parts; a `Table` where the curve is one."""
    return (Table if curve.tabulated else Law)(contact, curve, unloading)


def join(
    contact: Contact, curve: "FormulaCurve | TableCurve", unloading: "str | os.PathLike | Law", max_force: float = math.inf
) -> Any:
    """A curve of first loading joined with the unloading that a user named; NotPassive where the pair returns work at a force
    up to `max_force` [N]. A fitted unloading curve is made stiffer, within the noise of its points."""
    law = join_unchecked(contact, curve, unloading)
    try:
        refuse_unless_passive(law, max_force)
    except NotPassive as refusal:
        if getattr(unloading, "measured", None) is None or contact.size is not None:
            raise
        from demlaws.curves.branch import stiffened

        assert isinstance(unloading, Law)
        branch = Table(unloading.contact, stiffened(composed(contact, curve), unloading, refusal))
        law = join_unchecked(contact, curve, branch)
        refuse_unless_passive(law, max_force)
    return law


def join_up_to(contact: Contact, curve: "FormulaCurve", unloading: "str | os.PathLike | Law", max_force: Any) -> "Table":
    """As `join`, with the table of the curve up to `max_force` [N]."""
    table = composed(contact, curve).tabulate(max_force=max_force)
    parts = join(contact, curve, unloading, table.largest_force).unloading_parts
    return Table(contact, table.curve, _adapted(parts, contact, table.curve))


def join_unchecked(contact: Contact, curve: "FormulaCurve | TableCurve", unloading: "str | os.PathLike | Law") -> Any:
    """A curve of first loading joined with the unloading that a user named, whether the pair returns work or not."""
    named = read_unloading(unloading)
    if isinstance(named, Law):
        parts = Unloading(curve.definition.rule(GIVEN), named.curve, named.contact)
    else:
        parts = Unloading(curve.definition.rule(named))
    return composed(contact, curve, _adapted(parts, contact, curve))


def _adapted(unloading, contact, curve):
    """The unloading in the form that a curve of first loading is joined with."""
    if not curve.tabulated:
        return unloading
    unloading = beside_table(curve, contact, unloading)
    if unloading.curve is not None:
        from demlaws.curves.tabulate import rescaled

        return unloading._replace(curve=rescaled(curve, contact, unloading), contact=contact)
    if unloading.rule.curve == "law" and unloading.rule_parameters is None:
        return unloading._replace(rule_parameters=curve.rule_parameters(contact, unloading.rule))
    return unloading


def read_unloading(unloading: Any) -> Any:
    """What a user gives as `unloading`: the name of a rule as it is, the elastic law to follow, read where it is a path."""
    if isinstance(unloading, str) and unloading == GIVEN:
        raise DemlawsError(
            f"unloading {GIVEN!r} needs its curve: give a law or a table, unloading=dl.law(...) or dl.Table.load(...)"
        )
    if names_a_file(unloading):
        unloading = Table.load(unloading)
    if isinstance(unloading, Law) and unloading.unloading not in (
        "elastic",
        unloading.definition.default_rule(**unloading.options),
    ):
        raise DemlawsError(
            f"the contact unloads along the curve of first loading of this {unloading.name!r}, whose own unloading, "
            f"{unloading.unloading!r}, has no effect: give it with unloading='elastic' (law.joined('elastic'))"
        )
    return unloading


# --- tables


class Table(Law):
    """A law whose curve is a table with measured errors; its files.

    >>> law = dl.law("pohrt-popov", dl.Contact(4e-3, 32e9, sigma=2e-6, fractal_dimension=2.2), unloading="hertz")
    >>> table = law.tabulate(rtol=1e-5)
    >>> bool(table.force_error < 1e-5), table.collapses, abs(table.force(1e-6) / law.force(1e-6) - 1) < 1e-5
    (True, True, True)
    """

    curve: "TableCurve"

    def __repr__(self):
        text = (
            f"demlaws.Table of {self.name!r}: {self.nodes.u.size} rows, force within {self.force_error:.1e}, "
            f"stiffness within {self.stiffness_error:.1e}"
        )
        return text if self.unloading_law is None else f"{text}; unloading along {self.unloading_law!r}"

    @property
    def nodes(self) -> "Nodes":
        """Nodes of the curve of first loading, without units."""
        return self.curve.nodes

    @property
    def rtol(self) -> float:
        """The requested tolerance."""
        return self.curve.rtol

    @property
    def knots(self) -> "Knots | None":
        """`Knots` of a table made of points."""
        return self.curve.knots

    @property
    def length(self) -> float | np.ndarray:
        """Length [m] that makes overlaps dimensionless, one per contact."""
        return loading_part(self.params).length

    def bound_to(self, contact: Contact, surface_matters: bool = True) -> "Table":
        """The same curve for another contact (or array of contacts); only a law whose curve collapses allows that."""
        curve = self.curve if self.collapses else dataclasses.replace(self.curve, collapses=False)
        contact, unloading = curve.bound_to(contact, surface_matters), self.unloading_parts
        if unloading.curve is not None:
            unloading = unloading._replace(contact=unloading.curve.bound_to(contact, surface_matters=False))
        return Table(contact, self.curve, unloading)

    def uncertainty(self, overlap: ArrayLike) -> float | np.ndarray:
        """Standard uncertainty of the force of a table made of measured points.

        Parameters
        ----------
        overlap : float or array_like
            Overlaps [m].

        Returns
        -------
        float or ndarray
            Uncertainty [N]; NaN beyond the largest overlap of the points, and of points at fewer than 20 overlaps.
        """
        if self.knots is None:
            raise DemlawsError(
                f"the table of {self.name!r} was not made of measured points: it has no uncertainty but its certificate"
            )
        at, shape = self._shaped(overlap, "overlap", "m")
        with np.errstate(divide="ignore", invalid="ignore"):
            sigma = np.interp(np.log(at), np.log(self.knots.overlap), self.knots.uncertainty)
        return as_given(np.where(at > (1.0 + 1e-9) * self.knots.overlap[-1], np.nan, sigma).reshape(shape))

    def _out_of_range(self, overlap):
        return (
            f"overlap {as_typed(overlap, 'm')} is beyond the table, which ends at {self.largest_overlap:g} m "
            f"({self.largest_force:g} N): make it with a larger max_force"
        )

    def _force_out_of_range(self, force):
        return (
            f"force {as_typed(force, 'N')} is beyond the table, which ends at {self.largest_force:g} N: make it with a larger "
            "max_force"
        )

    # --- files

    def save(self, path: str | os.PathLike) -> File:
        """Write the table as text with its certificate, its unloading curve below it; see `Table.load`.

        Parameters
        ----------
        path : str or os.PathLike
            File to write.

        Returns
        -------
        pathlib.Path
            The file.
        """
        return write_atomically(path, self._compose()[0])

    @property
    def fingerprint(self) -> int:
        """Checksum (CRC-32) of the file that `save` writes: equal tables have equal checksums."""
        return self._compose()[1]

    def _compose(self):
        from demlaws.curves.table_file import compose

        return compose(self.contact, self.curve, self.unloading_parts, self.collapses)

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Table":
        """Read a table written by `save`; this version of demlaws need not have its law.

        Parameters
        ----------
        path : str or os.PathLike
            File to read.

        Returns
        -------
        Table

        Raises
        ------
        DemlawsError
            If the file is truncated, edited or not a table; the message gives the line.
        """
        from demlaws.curves.table_file import read

        return cls(*read(path))

    # --- user-defined curves

    @classmethod
    def from_function(
        cls,
        force: Callable,
        contact: Contact,
        largest_overlap: float | None = None,
        *,
        stiffness: Callable | None = None,
        unloading: Any = "elastic",
        kinks: Any = (),
        scales_with: str | None = None,
        rtol: float = 1e-5,
        name: str = "function",
        description: str = "a user-defined function",
    ) -> "Table":
        """The smallest `Table` of a rising force(overlap), within `rtol` of it and of its derivative.

        The function is called about 50,000 times, with one number each.

        Parameters
        ----------
        force : callable
            Force [N] of one overlap [m]; 0 at overlap 0, where it rises as δ or a higher power.
        contact : Contact
            The contact that the function describes.
        largest_overlap : float, optional
            End of the table [m]; default: a tenth of R. The last cell may continue a little, as a power law.
        stiffness : callable, optional
            Derivative of the force [N/m], which is checked; default: computed from the force.
        unloading : str or Law
            A rule, a law or a `Table` as for `demlaws.law`.
        kinks : array_like
            Overlaps [m] where the stiffness or its derivative is discontinuous.
        scales_with : {"radius", "roughness"}, optional
            The table serves other contacts, too: P/(E* R²) is a function of δ/R, or P/(E* √R σ^1.5) one of δ/σ.
        rtol : float
            Largest relative error of force and stiffness.
        name, description : str
            Name and description of the law.

        Returns
        -------
        Table

        Raises
        ------
        DemlawsError
            If the function raises, is not finite, is negative, falls, jumps, or has another derivative; with the overlap.
        """
        from demlaws.curves.user_curves import curve_of_function

        curve = curve_of_function(
            force,
            contact,
            largest_overlap,
            stiffness=stiffness,
            kinks=kinks,
            scales_with=scales_with,
            rtol=rtol,
            name=name,
            description=description,
        )
        return join(contact, curve, unloading)

    @classmethod
    def from_points(
        cls,
        points: Any,
        contact: Contact,
        unloading: Any = "elastic",
        *,
        uncertainty: ArrayLike | None = None,
        scales_with: str | None = None,
        rtol: float = 1e-3,
        name: str = "points",
        description: str = "measured points",
    ) -> "Table":
        """`Table` of a rising curve through measured points, smoothed by restricted likelihood.

        Below the first point the curve is a power law. `table.knots` has points of the curve with the standard uncertainty
        of their force.

        Parameters
        ----------
        points : array_like, shape (n, 2), or Points
            At least six overlaps [m] and forces [N] of first loading, in any order; also a DataFrame, as for `demlaws.fit`.
        contact : Contact
            The contact that was measured.
        unloading : str or Law
            A rule, a law or a `Table` as for `demlaws.law`.
        uncertainty : float or array_like, optional
            Standard uncertainty of the forces [N]; default: from the scatter.
        scales_with : {"radius", "roughness"}, optional
            As in `from_function`.
        rtol : float
            Largest relative distance of the table from the curve.
        name, description : str
            Name and description of the law.

        Returns
        -------
        Table

        Raises
        ------
        DemlawsError
            If points do not follow a rising curve, or are fewer than six; with overlap and force.
        """
        from demlaws.curves.user_curves import curve_of_points, limited_by_unloading

        curve, measured = curve_of_points(
            points,
            contact,
            uncertainty=uncertainty,
            scales_with=scales_with,
            rtol=rtol,
            name=name,
            description=description,
        )
        law = join_unchecked(contact, curve, unloading)
        try:
            refuse_unless_passive(law)
        except NotPassive:
            return join(contact, limited_by_unloading(curve, measured, law), unloading)
        return law
