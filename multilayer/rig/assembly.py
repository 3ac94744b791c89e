"""The rig's equations as a sum of constant matrices times functions of frequency, modulus and other parameters.

    sum_k c_k A_k v = - sum_k c_k A_k 1,        displacement = base motion (1 + v)

`1` is the rigid motion of everything with the base, so that stiffness matrices drop out of the right-hand side, and
``v = 0`` where the base is. In this form nothing but the coefficients ``c_k`` depends on frequency, modulus, density,
mass and (for the sample) thickness: see `coefficients`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, csr_matrix, diags_array

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.media.porous import champoux_allard_modulus, johnson_density
from multilayer.rig.mesh import Section
from multilayer.rig.operators import Operators, Sparse, basis_of, gradients, line_basis, mass, operators

if TYPE_CHECKING:
    from multilayer.rig.two_plate import TwoPlateRig

PRESSURE = 1e5  # Pa per m of base motion: the scale that makes pressures comparable with displacements


@dataclass(frozen=True)
class Parameters:
    """Arguments of one evaluation of the rig; arrays broadcast.

    Attributes
    ----------
    frequency : array
        Hz.
    modulus : complex array
        Young's modulus of the sample, Pa.
    density, thickness, plate_mass : array
        Of the sample and the top plate, relative to the rig's.
    """

    frequency: Any
    modulus: Any
    density: Any = 1.0
    thickness: Any = 1.0
    plate_mass: Any = 1.0


@dataclass(frozen=True)
class Assembly:
    """Matrices and loads on the free unknowns.

    Attributes
    ----------
    names : tuple of str
    matrices : tuple of sparse matrix, shape (n, n)
    loads : array, shape (n_terms, n)
        ``- A_k 1``.
    reading : array, shape (n,)
        Row that reads the relative motion of the top plate.
    """

    names: tuple[str, ...]
    matrices: tuple[Sparse, ...]
    loads: RealArray
    reading: RealArray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.reading)


def coefficients(rig: TwoPlateRig, names: tuple[str, ...], at: Parameters) -> ComplexArray:
    """Return the factors c_k of the named matrices at the parameters `at`, shape (n_terms, ...)."""
    omega2 = (2 * np.pi * np.asarray(at.frequency, dtype=float)) ** 2
    modulus, q = np.asarray(at.modulus, dtype=complex), at.thickness
    values: dict[str, Numeric] = {
        "sample_0": modulus * q,
        "sample_1": modulus,
        "sample_2": modulus / q,
        "sample_mass": -omega2 * rig.density * at.density * q,
        "stiff": 1.0,
        "plate_mass": -omega2 * at.plate_mass,
        "mass": -omega2,
        "adhesive": rig.glue(at.frequency) if rig.adhesive_thickness else 0.0,
        "flanking": rig.flanking(at.frequency) if rig.has_flank else 0.0,
        "attached": -omega2 * rig.attached(at.frequency) if rig.attached_mass is not None else 0.0,
    }
    if rig.porosity is not None:
        values |= _pore_coefficients(rig, at, omega2)
    arrays = np.broadcast_arrays(*(np.asarray(values[name], dtype=complex) for name in names))
    return np.stack(arrays)


def _pore_coefficients(rig: TwoPlateRig, at: Parameters, omega2: RealArray) -> dict[str, Numeric]:
    """Return the coefficients of the mixed form (u, p) of Biot's equations.

    N. Atalla, R. Panneton & P. Debergue, J. Acoust. Soc. Am. 104 (1998) 1444-1452, in the form whose natural condition
    is a sealed face that moves with the frame (N. Atalla, M. A. Hamdi & R. Panneton, ibid. 109 (2001) 3065-3068), for a
    frame material much stiffer than the frame.
    """
    omega, q = np.sqrt(omega2), at.thickness
    rho, bulk = pore_fluid(rig, omega)
    drag = rig.air.density / rho
    # rho11 - rho12^2/rho22 of `media.biot`, in terms of the equivalent fluid
    phi = np.asarray(rig.porosity)
    rho22 = phi**2 * rho
    rho12 = phi * rig.air.density - rho22
    frame = rig.density * at.density - rho12 - rho12**2 / rho22
    return {
        "sample_mass": -omega2 * frame * q,
        "pore_r": PRESSURE**2 * q / (omega2 * rho),
        "pore_z": PRESSURE**2 / q / (omega2 * rho),
        "pore_volume": -(PRESSURE**2) * q / bulk,
        "inertia_r": -PRESSURE * drag * q,
        "inertia_z": -PRESSURE * drag,
        "strain_r": -PRESSURE * q,
        "strain_z": -PRESSURE,
    }


def pore_fluid(rig: TwoPlateRig, omega: RealArray) -> tuple[ComplexArray, ComplexArray]:
    """Return density and bulk modulus of the equivalent fluid in the pores, per volume of material."""
    assert rig.porosity is not None
    assert rig.flow_resistivity is not None
    assert rig.viscous_length is not None
    assert rig.thermal_length is not None
    pores = (rig.porosity, rig.flow_resistivity, rig.tortuosity, rig.viscous_length)
    rho = johnson_density(omega, *pores, rig.air)
    return rho, champoux_allard_modulus(omega, rig.porosity, rig.thermal_length, rig.air)


def assemble(rig: TwoPlateRig, section: Section) -> Assembly:
    """Return the matrices of a rig on a mesh."""
    full = _full_terms(rig, section)
    mesh = section.mesh
    nodes = basis_of(mesh).doflocs
    n = nodes.shape[1]
    free = _free(rig, section, nodes)
    rigid = np.zeros(next(iter(full.values())).shape[0])
    rigid[n : 2 * n] = 1.0
    names = tuple(name for name, matrix in full.items() if matrix.nnz)
    # the flanking path joins base and plate: a common motion does not stretch it
    loads = np.stack([-(full[name] @ rigid)[free] * (name != "flanking") for name in names])
    reading = np.zeros(len(rigid))
    reading[n + _reading_node(rig, section, nodes)] = 1.0
    cut = tuple(csr_matrix(full[name][free][:, free]) for name in names)
    return Assembly(names, cut, loads, reading[free])


def _full_terms(rig: TwoPlateRig, section: Section) -> dict[str, Sparse]:
    mesh = section.mesh
    sample = basis_of(mesh, section.elements("sample"))
    parts = operators(sample, rig.stiffness_profile)
    radial, shear, axial = solid_parts(parts, rig.elastic_constants)
    n, fields = sample.N, 3 if rig.porosity is not None else 2
    terms = {
        "sample_0": blocks(fields, radial),
        "sample_1": blocks(fields, shear),
        "sample_2": blocks(fields, axial),
        "sample_mass": blocks(fields, _both(mass(sample))),
        **_plates(rig, section, fields),
        "flanking": _flank(rig, section, n, fields),
        "attached": _attached(rig, section, n, fields),
    }
    if rig.porosity is not None:
        terms |= _pores(operators(sample), gradients(sample), mass(sample))
    return terms


def sample_stiffness(rig: TwoPlateRig, section: Section) -> list[list[Sparse]]:
    """Return the matrices ``sample_0`` to ``sample_2`` on the free unknowns, in parts: one for each elastic constant.

    Each part times its constant, added up, is the matrix of `assemble`.

    Returns
    -------
    list of list of sparse matrix, shape (n, n)
        By power of the thickness (3) and elastic constant (5), in the order of `transversely_isotropic`.
    """
    sample = basis_of(section.mesh, section.elements("sample"))
    parts, fields = operators(sample, rig.stiffness_profile), 3 if rig.porosity is not None else 2
    free = _free(rig, section, basis_of(section.mesh).doflocs)
    by_constant = [solid_parts(parts, unit) for unit in np.eye(5)]
    return [[csr_matrix(blocks(fields, one[power])[free][:, free]) for one in by_constant] for power in range(3)]


def solid_parts(
    parts: Operators, elastic_constants: RealArray
) -> tuple[dict[tuple[int, int], Sparse], dict[tuple[int, int], Sparse], dict[tuple[int, int], Sparse]]:
    """Return the stiffness in blocks (row field, column field), for powers 1, 0 and -1 of the relative thickness.

    Parameters
    ----------
    parts : Operators
    elastic_constants : array, shape (5,)
        C_rr, C_rt, C_rz, C_zz, G over Young's modulus.
    """
    c_rr, c_rt, c_rz, c_zz, g = elastic_constants
    radial = {
        (0, 0): c_rr * (parts.rr + parts.over) + c_rt * (parts.r0 + parts.r0.T),
        (1, 1): g * parts.rr,
    }
    mixed = c_rz * (parts.zr + parts.z0) + g * parts.zr.T
    shear = {(0, 1): mixed, (1, 0): mixed.T}
    axial = {(0, 0): g * parts.zz, (1, 1): c_zz * parts.zz}
    return radial, shear, axial


def _both(matrix: Sparse) -> dict[tuple[int, int], Sparse]:
    return {(0, 0): matrix, (1, 1): matrix}


def blocks(fields: int, entries: dict[tuple[int, int], Sparse]) -> Sparse:
    """Return one matrix of `fields` by `fields` blocks, zero but for the entries."""
    n = next(iter(entries.values())).shape[0]
    empty = csr_matrix((n, n))
    rows = [[entries.get((i, j), empty) for j in range(fields)] for i in range(fields)]
    return csr_matrix(block_array(rows, format="csr"))


def _plates(rig: TwoPlateRig, section: Section, fields: int) -> dict[str, Sparse]:
    """Return everything that is not sample: plates, adhesive, accelerometer."""
    mesh = section.mesh
    n = basis_of(mesh).N
    empty = blocks(fields, {(0, 0): csr_matrix((n, n))})
    terms = {"stiff": empty, "plate_mass": empty, "mass": empty, "adhesive": empty}
    solids = {
        "plate": (rig.plate_modulus, rig.plate_poisson_ratio, rig.plate_density),
        "base": (rig.base_modulus, rig.base_poisson_ratio, rig.base_density),
        "adhesive": (1.0, rig.adhesive_poisson_ratio, rig.adhesive_density),
    }
    for name, (modulus, poisson_ratio, density) in solids.items():
        elements = section.elements(name)
        if not len(elements):
            continue
        basis = basis_of(mesh, elements)
        parts = solid_parts(operators(basis), isotropic(poisson_ratio))
        stiffness = sum((blocks(fields, part) for part in parts), start=empty)
        kind = "adhesive" if name == "adhesive" else "stiff"
        terms[kind] = terms[kind] + modulus * stiffness
        kind = "plate_mass" if name == "plate" else "mass"
        terms[kind] = terms[kind] + density * blocks(fields, _both(mass(basis)))
    if rig.sensor_mass:
        terms["mass"] = terms["mass"] + rig.sensor_mass * blocks(fields, _both(_sensor(rig, section)))
    return terms


def isotropic(poisson_ratio: float) -> RealArray:
    """Return C_rr, C_rt, C_rz, C_zz, G of an isotropic solid of unit Young's modulus."""
    return transversely_isotropic(poisson_ratio, 1.0, 1.0)


def transversely_isotropic(poisson_ratio: float, transverse_ratio: float, shear_ratio: float) -> RealArray:
    """Return C_rr, C_rt, C_rz, C_zz, G over the axial Young's modulus E_z.

    In the compliance ``-nu/E_r`` couples the transverse directions and ``-nu/sqrt(E_r E_z)`` a transverse one with the
    axis: the isotropic compliance, scaled from both sides, and so positive for the same Poisson's ratios.
    """
    root = np.array([transverse_ratio, transverse_ratio, 1.0]) ** 0.5
    unit = (1 + poisson_ratio) * np.eye(3) - poisson_ratio * np.ones((3, 3))
    stiff = np.linalg.inv(unit) * np.outer(root, root)
    shear = shear_ratio * transverse_ratio**0.5 / (2 * (1 + poisson_ratio))
    return np.array([stiff[0, 0], stiff[0, 1], stiff[0, 2], stiff[2, 2], shear])


def _pores(parts: Operators, slopes: tuple[Sparse, Sparse, Sparse], unit: Sparse) -> dict[str, Sparse]:
    """Return the blocks of the pressure (field 2) and its couplings with the displacement (fields 0 and 1)."""
    along_r, along_z, hoop = slopes  # rows: the field tested; columns: the field whose derivative is taken
    widening = along_r + hoop  # rows p, columns u_r
    return {
        "pore_r": blocks(3, {(2, 2): parts.rr}),
        "pore_z": blocks(3, {(2, 2): parts.zz}),
        "pore_volume": blocks(3, {(2, 2): unit}),
        "inertia_r": blocks(3, {(0, 2): along_r, (2, 0): along_r.T}),
        "inertia_z": blocks(3, {(1, 2): along_z, (2, 1): along_z.T}),
        "strain_r": blocks(3, {(2, 0): widening, (0, 2): widening.T}),
        "strain_z": blocks(3, {(2, 1): along_z, (1, 2): along_z.T}),
    }


def _sensor(rig: TwoPlateRig, section: Section) -> Sparse:
    """Return the mass matrix of 1 kg spread evenly over the accelerometer's footprint on the top plate."""
    mesh, top = section.mesh, section.heights[-1]
    low, high = rig.footprint
    facets = mesh.facets_satisfying(
        lambda x: np.isclose(x[1], top) & (x[0] > low) & (x[0] < high), boundaries_only=True
    )
    spread = mass(line_basis(mesh, facets))
    return csr_matrix(spread / spread.sum())


def _attached(rig: TwoPlateRig, section: Section, n: int, fields: int) -> Sparse:
    """Return the matrix of a dynamic mass of 1 kg on the top plate."""
    if rig.attached_mass is None:
        return csr_matrix((fields * n, fields * n))
    return csr_matrix(blocks(fields, _both(_sensor(rig, section))))


def _flank(rig: TwoPlateRig, section: Section, n: int, fields: int) -> Sparse:
    """Return the matrix of a spring between the base and the lower edge of the top plate."""
    diagonal = np.zeros(fields * n)
    if rig.has_flank:
        edge = (section.radii[-1], next(slab.bottom for slab in section.slabs if slab.name == "plate"))
        diagonal[n + _nearest(basis_of(section.mesh, section.elements("plate")), edge)] = 1.0
    matrix = csr_matrix(diags_array(diagonal))
    matrix.eliminate_zeros()
    return matrix


def _reading_node(rig: TwoPlateRig, section: Section, nodes: RealArray) -> int:
    return _nearest_of(nodes, (rig.reading, section.heights[-1]))


def _nearest_of(nodes: RealArray, place: tuple[float, float]) -> int:
    return int(np.argmin(np.hypot(nodes[0] - place[0], nodes[1] - place[1])))


def _nearest(basis: Any, place: tuple[float, float]) -> int:
    """Return the node of a part nearest to a place: at an open interface each side has its nodes."""
    of_part = np.unique(basis.element_dofs)
    return int(of_part[_nearest_of(basis.doflocs[:, of_part], place)])


def _free(rig: TwoPlateRig, section: Section, nodes: RealArray) -> NDArray[np.intp]:
    """Return the unknowns that are neither prescribed nor without an equation."""
    r, z = nodes
    scale = section.radii[-1]
    held = np.isclose(z, section.heights[0], atol=1e-9 * scale)
    if (
        section.slabs[0].name == "sample" and rig.open_faces != "top"
    ):  # the sample stands on the rigid base where it is bonded
        held &= r <= rig.bonded_radius * (1 + 1e-9)
    radial, axial = ~held, ~held
    radial = radial & (r > 1e-9 * scale)
    in_sample = np.zeros(len(r), dtype=bool)
    in_sample[np.unique(basis_of(section.mesh, section.elements("sample")).element_dofs)] = True
    rim = in_sample & np.isclose(r, scale)
    if rig.rim == "held":
        radial = radial & ~rim
    unknown = [radial, axial]
    if rig.porosity is not None:
        unknown.append(in_sample & ~rim if rig.pore_rim == "open" else in_sample)
    return np.flatnonzero(np.concatenate(unknown))
