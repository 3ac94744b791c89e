"""What happens where two faces touch, and at walls and free faces."""

from itertools import product

import numpy as np
import pytest

from multilayer.matrix import couplings
from multilayer.matrix.couplings import CouplingError, couple, register_coupling, void_rows, wall_rows
from multilayer.matrix.families import FLUID, POROELASTIC, SOLID, Family

FAMILIES = [FLUID, SOLID, POROELASTIC]
POROSITIES = {FLUID: 1.0, SOLID: 1.0, POROELASTIC: 0.9}
PAIRS = [pytest.param(a, b, "bonded", id=f"{a.name}-{b.name}") for a, b in product(FAMILIES, FAMILIES)] + [
    pytest.param(a, b, "slip", id=f"{a.name}-{b.name}-slip")
    for a, b in (*product(FAMILIES[1:], FAMILIES[1:]), (FLUID, POROELASTIC), (POROELASTIC, FLUID))
]
GAS = Family("plasma", ("p", "v3"), ((1, 0, 1),), even=(0,))


def coupled(front, back, contact):
    porosity_back = 0.6 if front is back is POROELASTIC else POROSITIES[back]
    return [np.array(rows, dtype=float) for rows in couple(front, back, contact, POROSITIES[front], porosity_back)]


def allowed_states(rows):
    """Return a basis of the states that the rows annihilate, one per column."""
    _, sizes, vectors = np.linalg.svd(rows)
    assert sizes.min() > 1e-6 * sizes.max(), "two conditions are the same"
    return vectors[len(rows) :].T


def power(family, states):
    """Return the power towards +x3 that each pair of real states exchanges."""
    form = np.zeros((family.size, family.size))
    for velocity, stress, sign in family.power_pairs:
        form[velocity, stress] = form[stress, velocity] = sign
    return states.T @ form @ states


@pytest.mark.parametrize(("front", "back", "contact"), PAIRS)
def test_as_many_conditions_as_waves_leave_the_interface(front, back, contact):
    i_rows, j_rows = coupled(front, back, contact)
    assert i_rows.shape == (front.half + back.half, front.size)
    assert j_rows.shape == (front.half + back.half, back.size)


@pytest.mark.parametrize(("front", "back", "contact"), PAIRS)
def test_an_interface_passes_all_power_on(front, back, contact):
    i_rows, j_rows = coupled(front, back, contact)
    states = allowed_states(np.hstack([i_rows, j_rows]))
    here, beyond = states[: front.size], states[front.size :]
    np.testing.assert_allclose(power(front, here), power(back, beyond), atol=1e-12)


@pytest.mark.parametrize(("front", "back", "contact"), PAIRS)
def test_either_order_says_the_same(front, back, contact):
    phi = POROSITIES[front], POROSITIES[back]
    one = np.hstack([np.array(rows, dtype=float) for rows in couple(front, back, contact, *phi)])
    other = np.hstack([np.array(rows, dtype=float) for rows in couple(back, front, contact, *phi[::-1])[::-1]])
    np.testing.assert_allclose(other @ allowed_states(one), 0, atol=1e-12)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.name)
def test_a_face_against_its_like_is_continuous(family):
    i_rows, j_rows = (np.array(rows, dtype=float) for rows in couple(family, family, "bonded", 0.8, 0.8))
    np.testing.assert_allclose(np.linalg.solve(i_rows, -j_rows), np.eye(family.size), atol=1e-12)


def test_slip_carries_no_shear():
    for front, back in product(FAMILIES[1:], FAMILIES[1:]):
        states = allowed_states(np.hstack(coupled(front, back, "slip")))
        shear = [i for i, name in enumerate((*front.components, *back.components)) if name.startswith("s13")]
        assert len(shear) == 2
        np.testing.assert_allclose(states[shear], 0, atol=1e-12)


@pytest.mark.parametrize("other", FAMILIES[:2], ids=lambda f: f.name)
def test_slip_beside_a_fluid_is_refused_with_words(other):
    for pair in ((FLUID, other), (other, FLUID)):
        with pytest.raises(CouplingError, match="slips anyway: leave the contact out"):
            couple(*pair, "slip")


@pytest.mark.parametrize("other", FAMILIES, ids=lambda f: f.name)
def test_an_unknown_pair_names_both(other):
    for front, back in ((GAS, other), (other, GAS)):
        with pytest.raises(CouplingError) as caught:
            couple(front, back, "bonded")
        expected = f"no 'bonded' coupling is known for a {front.name} face against a {back.name} face"
        assert str(caught.value) == expected


def test_a_new_family_registers_one_order_and_serves_both(monkeypatch):
    monkeypatch.setattr(couplings, "_COUPLINGS", dict(couplings._COUPLINGS))
    rows = ((1, 0), (0, 1)), ((-2, 0), (0, -1))
    register_coupling(GAS, FLUID, "bonded", lambda front, back: rows)
    assert couple(GAS, FLUID, "bonded") == rows
    assert couple(FLUID, GAS, "bonded") == rows[::-1]


WALLS = [
    (family, contact) for family in FAMILIES for contact in ("bonded", "slip") if (family, contact) != (FLUID, "slip")
]


@pytest.mark.parametrize(("family", "contact"), WALLS)
def test_a_wall_takes_no_power(family, contact):
    rows, normal = wall_rows(family, contact)
    assert len(rows) == len(normal) == family.half
    states = allowed_states(np.array(rows, dtype=float))
    np.testing.assert_allclose(power(family, states), 0, atol=1e-12)
    held = [family.components[int(np.argmax(row))] for row, moves in zip(rows, normal, strict=True) if moves]
    assert held == [name for name in family.components if name.startswith("v3")]


@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.name)
def test_a_free_face_gives_no_power(family):
    rows = np.array(void_rows(family), dtype=float)
    assert rows.shape == (family.half, family.size)
    np.testing.assert_allclose(power(family, allowed_states(rows)), 0, atol=1e-12)


def test_walls_and_free_faces_that_are_not_known():
    with pytest.raises(CouplingError, match="no 'slip' contact is known between a fluid face and a wall"):
        wall_rows(FLUID, "slip")
    with pytest.raises(CouplingError, match="no 'bonded' contact is known between a plasma face and a wall"):
        wall_rows(GAS)
    with pytest.raises(CouplingError, match="no free face is known for a plasma layer"):
        void_rows(GAS)
