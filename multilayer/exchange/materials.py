"""Materials from other programs' tables: a row for each, columns by common names and symbols, to a library of ours."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from multilayer.bounds import YAML_NAMES
from multilayer.config.yaml12 import dump_yaml
from multilayer.errors import InputError, PlausibilityWarning, Problem, show
from multilayer.files import is_file
from multilayer.layers.base import LAYERS, layer_type
from multilayer.tables import Header, Table, other_width, read_text_table
from multilayer.units import field_unit, parse_quantity
from multilayer.writing.manifest import note_input

_THICKNESS = 0.05  # m; a library's material has none, and a layer to be checked needs some
_HEAVIEST = 2e4  # kg/m3, of a frame's material: beyond all but gold and platinum
_TEXTS = ("source", "note", "model", "type")
_DENSITY, _FRAME_DENSITY = "density", "frame_density"  # of a solid, and of a frame over the whole volume
_SOLID_DENSITY, _SHEAR = "solid_density", "shear_modulus"
_MADE = "# Made by `multilayer materials --from`\n"  # ahead of a library
_UNITS_OF_OTHERS = {_SOLID_DENSITY: "kg/m^3", _SHEAR: "Pa"}

NAMES: dict[str, tuple[str, ...]] = {
    "name": ("name", "material", "material_name", "id"),
    "type": ("type", "layer_type"),
    "model": ("model", "pore_model"),
    "source": ("source", "reference"),
    "note": ("note", "comment", "remark", "description"),
    "flow_resistivity": (
        "flow_resistivity", "airflow_resistivity", "air_flow_resistivity", "static_airflow_resistivity", "resistivity",
        "sigma", "σ", "afr", "r",
    ),
    "porosity": ("porosity", "open_porosity", "phi", "φ", "ϕ", "por"),
    "tortuosity": (
        "tortuosity", "alpha_inf", "alpha_infinity", "alphainf", "alpha_∞", "α∞", "α_∞", "α_inf", "tor",
    ),
    "viscous_length": (
        "viscous_length", "viscous_characteristic_length", "viscous_char._length", "lambda", "lambda_v", "λ", "λ_v",
        "vcl", "vle", "lv",
    ),
    "thermal_length": (
        "thermal_length", "thermal_characteristic_length", "thermal_char._length", "lambda'", "lambda_prime",
        "lambda_t", "lambda′", "λ'", "λ′", "λ’", "λ_t", "tcl", "tle", "lt",
    ),
    "thermal_permeability": (
        "thermal_permeability", "static_thermal_permeability", "k0'", "k'0", "k_0'", "k0_prime", "k0′", "k′0",
    ),
    "frame_density": (
        "frame_density", "density", "bulk_density", "apparent_density", "rho", "rho_1", "rho1", "ρ", "ρ1", "ρ_1",
    ),
    _SOLID_DENSITY: ("solid_density", "skeleton_density", "rho_s", "rhos", "ρs", "ρ_s"),
    "young_modulus": ("young_modulus", "young's_modulus", "youngs_modulus", "young", "e", "modulus"),
    _SHEAR: ("shear_modulus", "n", "g"),
    "poisson_ratio": ("poisson_ratio", "poisson's_ratio", "poissons_ratio", "poisson", "nu", "ν"),
    "loss_factor": (
        "loss_factor", "structural_loss_factor", "damping_loss_factor", "structural_damping", "damping", "eta", "η",
    ),
}  # fmt: skip
"""By field of a layer, what columns may be called, in small letters, blanks as underscores."""
_FIELD_OF = {name: key for key, names in NAMES.items() for name in names}


@dataclass(frozen=True)
class Imported:
    """Materials of a table.

    Attributes
    ----------
    file : Path
    materials : mapping
        Fields by name, SI, as a library has them.
    left_out : tuple of str
        Columns that no field is known for.
    """

    file: Path
    materials: Mapping[str, Mapping[str, Any]]
    left_out: tuple[str, ...] = ()

    @property
    def library(self) -> str:
        """The text of a library file."""
        data = {"kind": "library", "version": 1, "materials": {k: dict(v) for k, v in self.materials.items()}}
        return f"{_MADE}{dump_yaml(data)}"


def refuse_library_of_others(file: Path) -> None:
    """Refuse to replace a library that was not made of a table.

    Parameters
    ----------
    file : Path
        Where a library is to be written.

    Raises
    ------
    InputError
    """
    if not is_file(file):
        return
    try:
        with file.open("rb") as stream:
            is_made = stream.read(len(_MADE)) == _MADE.encode()
    except OSError:
        is_made = False
    if not is_made:
        text = "there is such a file already, and it was not made of a table; choose another --out, or remove it first"
        raise InputError(f"{file}: {text}")


def read_materials(path: Path | str) -> Imported:
    """Read a table of porous materials, as other programs and papers have them.

    Columns are separated by commas, semicolons or tabs, their names as in `NAMES`; units stand in brackets behind the
    names (``sigma [N s/m4]``), or behind the numbers of the cells. ``rho_s`` is the density of the frame's own material
    and needs a porosity, a shear modulus needs a Poisson's ratio. A row with a modulus is ``poroelastic``, else with a
    density ``limp``, else an ``equivalent_fluid``; a column ``type`` may say another, of a solid too, whose density it
    then is. The pores are those of model ``jca``, with a thermal permeability ``jcal``; a column ``model`` may say
    another.

    Parameters
    ----------
    path : Path or str
        A text.

    Raises
    ------
    InputError
        With every mistake, by line and column: a cell that is no number or out of range, or may have separators between
        thousands, a unit that is missing or wrong, a material that lacks a field, has no name or one that is there
        twice.

    Warns
    -----
    PlausibilityWarning
        Of values that are hardly meant, as lengths that are exchanged.
    """
    file = Path(path)
    table = read_text_table(file)
    note_input(file)
    if not table.headers:
        raise table.error("is empty; its first line must name the columns, as 'name, sigma [N s/m4], phi'")
    columns, left_out = _columns(table)
    if not table.rows:
        raise table.error("holds no material below its header")
    YAML_NAMES.check(len(table.rows), file, "make several libraries of it")
    if unclear := list(_thousands(table, columns)):
        raise InputError(unclear)
    problems: list[Problem] = []
    materials: dict[str, dict[str, Any]] = {}
    lines: dict[str, int | None] = {}
    for line, cells in table.rows:
        row = _Row(table, columns, line, cells)
        name, fields = row.material()
        if name in materials:
            row.problem("name", f"another material is called {show(name)}, in line {lines[name]}; names must differ")
        problems += row.problems
        materials[name], lines[name] = fields, line
    if problems:
        raise InputError(problems)
    return Imported(file, materials, left_out)


def _columns(table: Table) -> tuple[dict[str, tuple[int, Header]], tuple[str, ...]]:
    """Return index and header of each field's column, and the names of the other columns."""
    columns: dict[str, tuple[int, Header]] = {}
    left_out = []
    for index, header in enumerate(table.headers):
        key = _FIELD_OF.get(header.name)
        if key is None:
            left_out += [header.text] if header.text else []
        elif key in columns:
            text = f"columns '{columns[key][1].text}' and '{header.text}' are both {key}; keep one of them"
            raise table.error(text, table.line)
        else:
            columns[key] = index, header
    if "name" not in columns:
        names = ", ".join(repr(name) for name in NAMES["name"])
        raise table.error(f"no column names the materials; call one of them {names}", table.line)
    return columns, tuple(left_out)


def _thousands(table: Table, columns: Mapping[str, tuple[int, Header]]) -> Iterator[Problem]:
    """Yield the columns of numbers that may have separators between thousands."""
    for key, (index, header) in columns.items():
        if key not in ("name", *_TEXTS) and (thousands := table.thousands(index)):
            line, text = thousands
            yield Problem(f"column '{header.text}': {text}", file=table.file, line=line)


class _Row:
    """One row: its material, and the mistakes in it."""

    def __init__(
        self, table: Table, columns: Mapping[str, tuple[int, Header]], line: int | None, cells: tuple[Any, ...]
    ) -> None:
        self.table, self.columns, self.line = table, columns, line
        self.cells = cells
        self.problems: list[Problem] = []
        if len(cells) > len(table.headers):
            self.problem("", other_width(len(cells), len(table.headers)))

    def problem(self, key: str, text: str) -> None:
        """Note a mistake in the column of a field, or in the row where there is none."""
        self.problems.append(self._placed(key, text))

    def _placed(self, key: str, text: str) -> Problem:
        where = f"column '{self.columns[_column_of(key)][1].text}': " if _column_of(key) in self.columns else ""
        return Problem(f"{where}{text}", file=self.table.file, line=self.line)

    def text(self, key: str) -> str:
        """Return the cell of a field; empty where there is none."""
        index = self.columns[key][0] if key in self.columns else len(self.cells)
        return self.table.cell(self.cells[index]) if index < len(self.cells) else ""

    def material(self) -> tuple[str, dict[str, Any]]:
        """Return name and fields."""
        name = self.text("name")
        if not name:
            self.problem("name", "a material has no name")
        fields: dict[str, Any] = {key: self.text(key) for key in _TEXTS if self.text(key)}
        fields.setdefault("source", f"{self.table.file.name}, line {self.line}")
        numbers = dict(self._numbers())
        self._frame(numbers)
        if _FRAME_DENSITY in numbers and _is_solid(fields.get("type", "")):
            numbers[_DENSITY] = numbers.pop(_FRAME_DENSITY)
        fields |= numbers
        fields.setdefault("type", self._type(numbers))
        if "thermal_permeability" in numbers:
            fields.setdefault("model", "jcal")
        if not self.problems:
            self._check(fields)
        ordered = {key: fields[key] for key in (*_TEXTS, *NAMES, _DENSITY) if key in fields}
        return name, ordered

    def _numbers(self) -> Iterator[tuple[str, float]]:
        for key, (_, header) in self.columns.items():
            written = self.text(key)
            if key in ("name", *_TEXTS) or written in ("", "-", "–"):
                continue
            try:
                number = _rounded(_number(header, key, self.table.pointed(written)))
            except ValueError as error:
                self.problem(key, str(error))
                continue
            if isfinite(number):
                yield key, number
            else:  # of a field that the layer does not take, nobody else would tell
                self.problem(key, f"'{written}' is no number; leave the cell empty where there is no value")

    def _frame(self, numbers: dict[str, float]) -> None:
        """Put our fields in place of the frame's density of solid and shear modulus."""
        for given, wanted, other in (
            (_SOLID_DENSITY, "frame_density", "porosity"),
            (_SHEAR, "young_modulus", "poisson_ratio"),
        ):
            if given not in numbers:
                continue
            value = numbers.pop(given)
            if wanted in numbers:
                self.problem(given, f"{wanted} is given, too; keep one of the two")
            elif other not in numbers:
                self.problem(given, f"needs a {other} beside it")
            elif given == _SOLID_DENSITY:
                numbers[wanted] = _rounded(value * (1 - numbers[other]))
            else:
                numbers[wanted] = _rounded(2 * value * (1 + numbers[other]))

    @staticmethod
    def _type(numbers: Mapping[str, float]) -> str:
        if "young_modulus" in numbers:
            return "poroelastic"
        return "limp" if "frame_density" in numbers else "equivalent_fluid"

    def _check(self, fields: Mapping[str, Any]) -> None:
        """Validate the fields as a layer's."""
        try:
            kind = layer_type(fields["type"])
        except InputError as error:
            self.problem("type", str(error))
            return
        of_layer = {key: value for key, value in fields.items() if key not in ("source", "note")}
        taken = kind.fields_taken(of_layer)
        tried = {key: value for key, value in of_layer.items() if key in taken}
        if "thickness" in kind.model_fields:
            tried["thickness"] = _THICKNESS
        try:
            layer = kind.model_validate(tried)
        except ValidationError as error:
            for details in error.errors(include_url=False):
                key = str(details["loc"][0]) if details["loc"] else ""
                what = "" if _column_of(key) in self.columns else f"{key} " if key else ""
                self.problem(key, f"{what}{details['msg'].removeprefix('Value error, ')}")
            return
        for key, text in (*layer.implausible(), *self._too_heavy(fields)):
            warnings.warn(str(self._placed(key, text)), PlausibilityWarning, stacklevel=5)

    @staticmethod
    def _too_heavy(fields: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Ask back a density of the frame that no material has: often it is that of the material."""
        density, porosity = fields.get("frame_density"), fields.get("porosity")
        if density is None or porosity is None or density <= _HEAVIEST * (1 - porosity):
            return
        solid = density / (1 - porosity)
        text = f"{density:g} kg/m3 at a porosity of {porosity:g} is a frame of a material of {solid:.3g} kg/m3"
        yield "frame_density", f"{text}; is it that material's density? Then call the column rho_s"


def _column_of(field: str) -> str:
    """Return which of `NAMES` a field of a layer is read as."""
    return _FRAME_DENSITY if field == _DENSITY else field


def _is_solid(kind: str) -> bool:
    """Tell whether layers of a type have a density, and no frame with pores; not of a type that there is not."""
    try:
        fields = layer_type(kind).model_fields
    except InputError:
        return False
    return _DENSITY in fields and _FRAME_DENSITY not in fields


def _number(header: Header, key: str, written: str) -> float:
    """Return a cell as a number in SI: its unit stands behind it, or in the header."""
    unit = _unit_of(key)
    try:
        number = float(written)
    except ValueError:
        return parse_quantity(written, unit)
    if header.unit not in (None, "", "-", "1"):
        return parse_quantity(f"{written} {header.unit}", unit)
    if unit:
        named = f"{header.text.partition('[')[0].strip()} [{unit.replace('*', ' ')}]"
        raise ValueError(f"{written} has no unit; call the column '{named}', or in whatever unit its numbers are")
    return parse_quantity(number, unit)


def _rounded(value: float) -> float:
    """Return a number without the last digits, which the change of units makes."""
    return float(f"{value:.12g}")


def _unit_of(key: str) -> str:
    if key in _UNITS_OF_OTHERS:
        return _UNITS_OF_OTHERS[key]
    return field_unit(LAYERS["poroelastic"].model_fields[key]) or ""
