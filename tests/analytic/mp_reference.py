"""The exact response of a stack, in many digits and by another road than the kernel's.

Unknown are the amplitudes of all plane waves of all layers, in displacements; one matrix holds every interface
condition, and mpmath solves it. Nothing of the kernel is used but the numbers in the fields of a `Stack`. Sources of
the equations: Newton's and Hooke's laws; Biot, J. Acoust. Soc. Am. 28 (1956) 168, in his displacements (u, U); the
pore fluid after Johnson et al. (1987) and Champoux & Allard (1991).
"""

from __future__ import annotations

import mpmath as mp

from multilayer.paths import locate, with_values

DIGITS = 80  # a foil at 1 Hz loses 60 of them
I = mp.mpc(0, 1)  # noqa: E741


class Field:
    """What every wave has in common, and the formulae of the media in it."""

    def __init__(self, gas, frequency: float, angle: float) -> None:
        self.omega = 2 * mp.pi * mp.mpf(frequency)
        self.kx = self.omega / mp.mpf(gas.sound_speed) * mp.sin(mp.mpf(angle) * mp.pi / 180)
        self.gas = {name: mp.mpf(value) for name, value in vars(gas).items()}

    def q(self, square):
        """Return the wavenumber along x3 of a wave that decays, or travels, towards +x3."""
        root = mp.sqrt(square - self.kx**2)
        return -root if root.imag > 0 else root

    def fluid(self, layer):
        density = mp.mpf(self.gas["density"] if layer.density is None else layer.density)
        speed = mp.mpf(self.gas["sound_speed"] if layer.sound_speed is None else layer.sound_speed)
        q = self.q((self.omega / speed) ** 2)

        def state(s):
            return {"p": mp.mpf(1), "u3": -I * s * q / (density * self.omega**2)}

        return [(q, state)]

    def elastic_solid(self, layer):
        modulus, nu, density = self.modulus(layer), mp.mpf(layer.poisson_ratio), mp.mpf(layer.density)
        lam, mu = modulus * nu / ((1 + nu) * (1 - 2 * nu)), modulus / (2 * (1 + nu))
        waves = []
        for square, longitudinal in (
            (self.omega**2 * density / (lam + 2 * mu), True),
            (self.omega**2 * density / mu, False),
        ):
            q = self.q(square)

            def state(s, q=q, longitudinal=longitudinal):
                u1, u3 = (self.kx, s * q) if longitudinal else (-s * q, self.kx)
                dilatation = -I * (self.kx * u1 + s * q * u3)
                return {
                    "u1": u1,
                    "u3": u3,
                    "s33": lam * dilatation - 2 * mu * I * s * q * u3,
                    "s13": -I * mu * (s * q * u1 + self.kx * u3),
                }

            waves.append((q, state))
        return waves

    def poroelastic(self, layer):
        N, P, Q, R, rho11, rho12, rho22 = self.biot(layer)
        w2 = self.omega**2
        # w^2 [rho] (a, b) = k^2 [[P, Q], [Q, R]] (a, b)
        b = P * rho22 + R * rho11 - 2 * Q * rho12
        root = mp.sqrt(b**2 - 4 * (P * R - Q**2) * (rho11 * rho22 - rho12**2))
        kinds = []
        for sign in (1, -1):
            square = w2 * (b + sign * root) / (2 * (P * R - Q**2))
            kinds.append((square, R * square - w2 * rho22, w2 * rho12 - Q * square, True))
        kinds.append((w2 * (rho11 - rho12**2 / rho22) / N, rho22, -rho12, False))
        waves = []
        for square, frame, pores, longitudinal in kinds:
            q = self.q(square)

            def state(s, q=q, frame=frame, pores=pores, longitudinal=longitudinal):
                e1, e3 = (self.kx, s * q) if longitudinal else (-s * q, self.kx)
                divergence = -I * (self.kx * e1 + s * q * e3)
                u1, u3, U3 = frame * e1, frame * e3, pores * e3
                e, E = frame * divergence, pores * divergence
                return {
                    "u1": u1,
                    "u3": u3,
                    "U3": U3,
                    "s33": (P - 2 * N) * e + Q * E - 2 * N * I * s * q * u3,
                    "s13": -I * N * (s * q * u1 + self.kx * u3),
                    "s": Q * e + R * E,
                }

            waves.append((q, state))
        return waves

    def biot(self, layer):
        gas, omega, modulus, nu = self.gas, self.omega, self.modulus(layer), mp.mpf(layer.poisson_ratio)
        names = ("porosity", "flow_resistivity", "tortuosity", "viscous_length", "thermal_length")
        phi, sigma, alpha, viscous, thermal = (mp.mpf(getattr(layer, name)) for name in names)
        rho0, eta, gamma = gas["density"], gas["viscosity"], gas["heat_capacity_ratio"]
        G = mp.sqrt(1 + 4 * I * alpha**2 * eta * rho0 * omega / (sigma * viscous * phi) ** 2)
        rho22 = phi * (alpha * rho0 + sigma * phi * G / (I * omega))
        x = I * omega * rho0 * gas["prandtl"] * thermal**2 / eta
        Kf = gamma * gas["pressure"] / (gamma - (gamma - 1) / (1 + 8 / x * mp.sqrt(1 + x / 16)))
        rho12 = phi * rho0 - rho22
        N, Kb = modulus / (2 * (1 + nu)), modulus / (3 * (1 - 2 * nu))
        P = 4 * N / 3 + Kb + (1 - phi) ** 2 * Kf / phi
        return N, P, (1 - phi) * Kf, phi * Kf, mp.mpf(layer.frame_density) - rho12, rho12, rho22

    @staticmethod
    def modulus(layer):
        return mp.mpmathify(layer.young_modulus) * (1 + I * mp.mpf(layer.loss_factor))


class Face:
    """Quantities at one face, each a row over all unknowns; `phi` is the open area of a porous one."""

    def __init__(self, phi=None) -> None:
        self.rows, self.phi = {}, phi

    def add(self, unknown, state, factor=1):
        for name, value in state.items():
            self.rows.setdefault(name, {})[unknown] = value * factor

    def __getattr__(self, name):
        return self.rows[name]

    @property
    def kind(self):
        if "U3" in self.rows:
            return "poroelastic"
        return "solid" if "u1" in self.rows else "fluid"


def total(*terms):
    """Return the sum of (factor, row) pairs."""
    result = {}
    for factor, row in terms:
        for unknown, value in row.items():
            result[unknown] = result.get(unknown, 0) + factor * value
    return result


def equal(a, b):
    return total((1, a), (-1, b))


def interface(a: Face, b: Face, contact: str) -> list:  # noqa: PLR0911
    """Return the rows that vanish where two faces touch."""
    kinds = a.kind, b.kind
    order = ("fluid", "solid", "poroelastic")
    if order.index(kinds[0]) > order.index(kinds[1]):
        return interface(b, a, contact)
    if kinds == ("fluid", "fluid"):
        return [equal(a.p, b.p), equal(a.u3, b.u3)]
    if kinds == ("fluid", "solid"):
        return [equal(a.u3, b.u3), total((1, a.p), (1, b.s33)), b.s13]
    if kinds == ("fluid", "poroelastic") and contact == "slip":  # a sheet that lies on the frame
        return [equal(a.u3, b.u3), equal(a.u3, b.U3), total((1, a.p), (1, b.s33), (1, b.s)), b.s13]
    if kinds == ("fluid", "poroelastic"):
        flow = total((1 - b.phi, b.u3), (b.phi, b.U3))
        return [
            equal(a.u3, flow), total((1 - b.phi, a.p), (1, b.s33)), total((b.phi, a.p), (1, b.s)), b.s13
        ]  # fmt: skip
    tangential = [a.s13, b.s13] if contact == "slip" else [equal(a.u1, b.u1), equal(a.s13, b.s13)]
    if kinds == ("solid", "solid"):
        return [equal(a.u3, b.u3), equal(a.s33, b.s33), *tangential]
    if kinds == ("solid", "poroelastic"):
        normal = [equal(a.u3, b.u3), equal(a.u3, b.U3), total((1, a.s33), (-1, b.s33), (-1, b.s))]
        return [*normal, *tangential]
    relative = [total((face.phi, face.U3), (-face.phi, face.u3)) for face in (a, b)]
    pressure = [total((1 / face.phi, face.s)) for face in (a, b)]
    stress = total((1, a.s33), (1, a.s), (-1, b.s33), (-1, b.s))
    return [equal(a.u3, b.u3), equal(*relative), stress, equal(*pressure), *tangential]


def against_wall(face: Face, contact: str, moving: bool = False) -> list:
    """Return the rows that vanish at a wall; a moving one has displacement 1, the unknown 1 standing for the number."""
    base = {1: mp.mpf(1)} if moving else {}
    rows = [equal(face.u3, base)]
    if face.kind == "poroelastic":
        rows.append(equal(face.U3, base))
    if face.kind != "fluid":
        rows.append(face.s13 if contact == "slip" else face.u1)
    return rows


def without_stress(face: Face) -> list:
    return [face.rows[name] for name in ("p", "s33", "s13", "s") if name in face.rows]


def layer_faces(field: Field, i: int, layer) -> tuple[Face, Face]:
    """Return the front and the back face of layer `i`; its unknowns are (i, 0), (i, 1), ..."""
    phi = mp.mpf(layer.porosity) if hasattr(layer, "porosity") else None
    front, back, h = Face(phi), Face(phi), mp.mpf(layer.thickness)
    if layer.type == "elastic_plate":  # unknown: pressure in front and displacement
        bending = field.modulus(layer) * h**3 / (12 * (1 - mp.mpf(layer.poisson_ratio) ** 2))
        force = bending * field.kx**4 - field.omega**2 * mp.mpf(layer.density) * h
        front.add((i, 0), {"p": mp.mpf(1), "u3": mp.mpf(0)})
        back.add((i, 0), {"p": mp.mpf(1), "u3": mp.mpf(0)})
        front.add((i, 1), {"p": mp.mpf(0), "u3": mp.mpf(1)})
        back.add((i, 1), {"p": -force, "u3": mp.mpf(1)})
        return front, back
    for j, (q, state) in enumerate(getattr(field, layer.type)(layer)):
        decay = mp.exp(-I * q * h)
        front.add((i, 2 * j), state(1))
        back.add((i, 2 * j), state(1), decay)
        front.add((i, 2 * j + 1), state(-1), decay)
        back.add((i, 2 * j + 1), state(-1))
    return front, back


def _unit(row: dict) -> dict:
    scale = max(abs(value) for value in row.values())
    return {unknown: value / scale for unknown, value in row.items()}


def _solve(rows: list) -> dict:
    """Solve for all unknowns but 1, which stands for the number one."""
    rows = [_unit(row) for row in rows]
    unknowns = sorted({unknown for row in rows for unknown in row if unknown != 1}, key=str)
    matrix, right = mp.matrix(len(rows), len(unknowns)), mp.matrix(len(rows), 1)
    for i, row in enumerate(rows):
        for j, unknown in enumerate(unknowns):
            matrix[i, j] = row.get(unknown, 0)
        right[i] = -row.get(1, 0)
    return dict(zip(unknowns, mp.lu_solve(matrix, right), strict=True))


def _chain(stack, field: Field):
    faces = [layer_faces(field, i, layer) for i, layer in enumerate(stack.layers)]
    rows = []
    for (_, a), (b, _), contact in zip(faces, faces[1:], stack.interfaces[1:-1], strict=False):
        rows += interface(a, b, contact)
    return faces, rows


def _ending(stack, field: Field, face: Face) -> list:
    if stack.termination == "rigid":
        return against_wall(face, stack.interfaces[-1])
    if stack.termination == "free":
        return without_stress(face)
    space = stack.ambient.gas if stack.termination == "ambient" else stack.termination
    ((_, state),) = field.fluid(space)
    outside = Face()
    outside.add("T", state(1))
    return interface(face, outside, stack.interfaces[-1])


def plane_wave(stack, frequency: float, angle: float) -> tuple[complex, complex | None]:
    """Return (R, T) of a `Stack`; T is None without a half-space behind."""
    with mp.workdps(DIGITS):
        reflected, transmitted = _plane_wave(stack, frequency, angle)
        return complex(reflected), None if transmitted is None else complex(transmitted)


def _plane_wave(stack, frequency: float, angle: float):
    field = Field(stack.ambient.gas, frequency, angle)
    faces, rows = _chain(stack, field)
    ((_, state),) = field.fluid(stack.ambient.gas)
    outside = Face()
    outside.add(1, state(1))
    outside.add("R", state(-1))
    rows += interface(outside, faces[0][0], stack.interfaces[0])
    rows += _ending(stack, field, faces[-1][1])
    result = _solve(rows)
    return result["R"], result.get("T")


def base_motion(stack, frequency: float) -> complex:
    """Return the normal motion of the last face over that of the base."""
    with mp.workdps(DIGITS):
        return complex(_base_motion(stack, frequency))


def _base_motion(stack, frequency: float):
    field = Field(stack.ambient.gas, frequency, 0.0)
    faces, rows = _chain(stack, field)
    rows += against_wall(faces[0][0], stack.interfaces[0], moving=True)
    rows += _ending(stack, field, faces[-1][1])
    result = _solve(rows)
    return sum(factor * result[unknown] for unknown, factor in faces[-1][1].u3.items())


def plane_wave_slopes(stack, path: str, frequency: float, angle: float) -> list[complex]:
    """Return the derivatives of R and, with a half-space behind, T by a field."""
    return _slopes(stack, path, lambda moved: _plane_wave(moved, frequency, angle))


def base_motion_slopes(stack, path: str, frequency: float) -> list[complex]:
    """Return the derivative of `base_motion` by a field."""
    return _slopes(stack, path, lambda moved: [_base_motion(moved, frequency)])


def _slopes(stack, path: str, response) -> list[complex]:
    """Return differences of second order, so fine that neither they nor rounding matter to 20 digits."""
    with mp.workdps(DIGITS + 40):
        value = mp.mpf(locate(stack, path).value)
        step = mp.mpf(10) ** -20 * (abs(value) or 1)
        ends = [response(with_values(stack, {path: value + sign * step})) for sign in (1, -1)]
        return [
            complex((after - before) / (2 * step)) for after, before in zip(*ends, strict=True) if after is not None
        ]
