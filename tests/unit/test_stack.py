"""Stacks: names, contacts, changed fields, what surrounds them, and the words for what is wrong."""

import numpy as np
import pytest
from pydantic import ValidationError

from multilayer.errors import InputError
from multilayer.layers.fluid import Fluid
from multilayer.matrix.couplings import CouplingError
from multilayer.media.gas import dry_air
from multilayer.paths import locate
from multilayer.response import base_motion, plane_wave
from multilayer.response.fields import fields, power_balance
from multilayer.stack import Ambient, FluidHalfSpace, Stack, load_stack

SOLID = {"type": "elastic_solid", "thickness": 0.01, "density": 100.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
SHEET = {**SOLID, "type": "elastic_plate"}
AIR = {"type": "fluid", "thickness": 0.05}


def stack(*layers, **fields):
    return Stack.model_validate({"layers": list(layers), **fields})


def words(**fields):
    """Return what is told about a stack that is refused."""
    with pytest.raises(ValidationError) as caught:
        Stack.model_validate({"layers": [SOLID], **fields})
    return " | ".join(error["msg"] for error in caught.value.errors())


def rubber_on_air(**fields):
    return stack({**SOLID, "name": "rubber"}, AIR, {**SOLID, "name": "skin"}, SOLID, **fields)


# names


def test_a_layer_goes_by_name_and_by_index():
    panel = rubber_on_air()
    assert [panel.index(key) for key in ("rubber", "skin", 0, 1, "2", "3")] == [0, 2, 0, 1, 2, 3]


def test_a_layer_nobody_knows():
    with pytest.raises(InputError, match=r"there is no layer 'ruber'; did you mean 'rubber'\?"):
        rubber_on_air().index("ruber")
    with pytest.raises(InputError, match="there is no layer '7'"):
        rubber_on_air().index(7)


def test_two_layers_of_one_name():
    layers = [{**SOLID, "name": "foam"}, {**AIR, "name": "foam"}]
    told = words(layers=layers)
    assert "called 'foam'" in told
    assert "names must differ" in told


def numbered():
    """Return a stack whose layers are called by numbers, which are the indices of others."""
    return [{**layer, "name": name} for name, layer in zip("1234", (AIR, SOLID, SOLID, SOLID), strict=True)]


def test_a_number_is_an_index_and_a_text_a_name_first():
    panel = stack(*numbered(), contacts=[{"between": ["2", "3"], "kind": "slip"}])
    assert [panel.index(key) for key in (0, 1, "1", "2", "0")] == [0, 1, 0, 1, 0]
    assert locate(panel, "layers.2.thickness").owner is panel.layers[panel.index("2")]
    assert panel.interfaces == ("bonded", "bonded", "slip", "bonded", "bonded")
    by_index = stack(*numbered(), contacts=[{"between": [2, 3], "kind": "slip"}])
    assert by_index.interfaces == ("bonded", "bonded", "bonded", "slip", "bonded")


def test_a_name_that_is_the_index_of_a_layer_without_one():
    told = words(layers=[{**AIR, "name": "1"}, SOLID])
    assert told == "layer 1 has no name and goes by its index; give that one a name, too"


def test_no_layer_is_called_as_the_wall_behind():
    assert "'termination' is what contacts call the wall behind" in words(layers=[{**AIR, "name": "termination"}])


def test_no_layers():
    assert "must not be empty" in words(layers=[])


# layers


def test_a_layer_of_no_type():
    assert "has no 'type'; allowed: " in words(layers=[{"thickness": 1.0}])
    assert "there is no layer type 'fluit'; did you mean 'fluid'?" in words(layers=[{"type": "fluit"}])
    assert "must be a mapping such as {type: fluid" in words(layers=["fluid"])
    assert words(layers=[{"Type": "fluid", "thickness": 1.0}]) == "there is no such field; did you mean 'type'?"
    assert "has no 'type'; allowed: " in words(layers=[{"type": None, "thickness": 1.0}])


def test_keys_beside_the_fields_are_suggested_as_well():
    assert "allowed: ambient, contacts, kind, layers, library, termination, version" in words(foo=1)
    assert "did you mean 'kind'?" in words(knid="stack")
    assert ", material, " in words(layers=[{**AIR, "foo": 1}])


def test_layers_made_in_python_stay_as_they_are():
    gap = Fluid(thickness=0.1)
    assert Stack(layers=(gap,)).layers[0] is gap


def test_a_stack_does_not_change():
    with pytest.raises(ValidationError):
        rubber_on_air().termination = "free"


# contacts


@pytest.mark.parametrize("pair", [("skin", 3), (3, "skin"), ("2", "3"), (2, 3)])
def test_a_contact_lies_between_neighbours_in_any_order(pair):
    panel = rubber_on_air(contacts=[{"between": pair, "kind": "slip"}])
    assert panel.interfaces == ("bonded", "bonded", "bonded", "slip", "bonded")


@pytest.mark.parametrize("pair", [(3, "termination"), ("termination", 3)])
def test_a_contact_with_what_lies_behind(pair):
    assert rubber_on_air(contacts=[{"between": pair, "kind": "slip"}]).interfaces[-1] == "slip"


def test_contacts_that_cannot_be():
    def told(pair, kind="slip"):
        return words(layers=[SOLID, AIR, SOLID], contacts=[{"between": pair, "kind": kind}])

    assert "0 and 2 are no neighbours" in told((0, 2))
    assert "1 and 1 are no neighbours" in told((1, 1))
    assert "0 and termination are no neighbours" in told((0, "termination"))
    assert "there is no layer 'skim'" in told((0, "skim"))
    assert "allowed: 'bonded' or 'slip'" in told((0, 1), "glued")


@pytest.mark.parametrize("again", [("b", "a"), (0, 1), ("a", 1)])
def test_two_contacts_of_one_interface(again):
    layers = [{**SOLID, "name": "a"}, {**SOLID, "name": "b"}, SOLID]
    contacts = [{"between": ["a", "b"], "kind": "slip"}, {"between": [1, 2], "kind": "slip"}]
    told = words(layers=layers, contacts=[*contacts, {"between": again, "kind": "bonded"}])
    assert told == f"{again[0]} and {again[1]} have a contact already, in contacts.0; keep one of the two"
    assert stack(*layers, contacts=contacts).interfaces == ("bonded", "slip", "slip", "bonded")


def test_a_contact_without_meaning_names_both_layers():
    panel = rubber_on_air(contacts=[{"between": ["rubber", 1], "kind": "slip"}])
    for respond in (plane_wave, base_motion):
        with pytest.raises(
            CouplingError, match=r"layers rubber and 1 \(fluid\): a solid face against a fluid face slips"
        ):
            respond(panel, 100.0)


# changed fields


def test_replaced_reaches_layers_by_name_and_by_index():
    panel = rubber_on_air()
    changed = panel.replaced({"layers.rubber.thickness": 0.02, "layers.3.density": 50.0})
    assert [layer.thickness for layer in changed.layers] == [0.02, 0.05, 0.01, 0.01]
    assert changed.layers[3].density == 50.0
    assert panel == rubber_on_air()


def test_replaced_by_arrays_broadcasts():
    thickness = np.array([0.01, 0.02, 0.04]).reshape(3, 1, 1)
    result = plane_wave(rubber_on_air().replaced({"layers.rubber.thickness": thickness}), [100.0, 200.0], [0.0, 30.0])
    assert result.reflection.shape == (3, 2, 2)
    assert np.all(np.abs(np.diff(result.reflection, axis=0)) > 0)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("layers.rubber.thicknes", "'layers.rubber.thicknes' leads nowhere: there is no 'thicknes'; did you mean "
                                   "'thickness'"),
        ("layers.foam.thickness", "'layers.foam.thickness' leads nowhere: there is no 'foam' in layers"),
        ("layers.rubber", "'layers.rubber' leads to no single value; name one of its fields: "),
        ("rubber.thickness", "'rubber.thickness' leads nowhere: there is no 'rubber'"),
        ("layers.rubber.young_modulus.real", "layers.rubber.young_modulus is 1"),
    ],
)  # fmt: skip
def test_replaced_on_a_path_that_leads_nowhere(path, message):
    with pytest.raises(InputError) as caught:
        rubber_on_air().replaced({path: 1.0})
    assert message in str(caught.value)


def test_a_path_through_a_name_with_a_point():
    panel = stack(AIR, {**SOLID, "name": "foam 1.5"})
    with pytest.raises(InputError, match=r"a path cannot hold the point in the name 'foam 1\.5': write its index, 1$"):
        panel.replaced({"layers.foam 1.5.thickness": 0.02})
    assert panel.replaced({"layers.1.thickness": 0.02}).layers[1].thickness == 0.02


# what surrounds it


def test_ambient_is_dry_air_unless_told():
    assert stack(AIR).ambient.gas == dry_air()
    assert Ambient(temperature="0 degC", pressure=9e4).gas == dry_air(273.15, 9e4)


@pytest.mark.parametrize("field", ["density", "sound_speed", "viscosity", "prandtl", "heat_capacity_ratio"])
def test_each_property_of_the_ambient_gas_can_be_given(field):
    gas = Ambient.model_validate({field: 1.5}).gas
    assert getattr(gas, field) == 1.5
    assert {name for name, value in vars(gas).items() if value != getattr(dry_air(), name)} == {field}


def test_impossible_gases():
    assert "must be above 1" in words(ambient={"heat_capacity_ratio": 1.0})
    assert "must be above 0" in words(ambient={"density": 0.0})


@pytest.mark.parametrize("termination", ["rigid", "ambient", "free"])
def test_terminations_by_name(termination):
    assert stack(AIR, termination=termination).termination == termination


def test_a_half_space_of_fluid():
    panel = stack(SHEET, termination={"type": "fluid", "density": "1000 kg/m3", "sound_speed": 1480})
    assert panel.termination == FluidHalfSpace(density=1000.0, sound_speed=1480.0)
    into_air = stack(SHEET, termination={"type": "fluid"})
    expected = plane_wave(stack(SHEET, termination="ambient"), 500.0, 30.0)
    assert plane_wave(into_air, 500.0, 30.0).transmission == expected.transmission


def test_terminations_that_are_none():
    assert "'soft' is not allowed; allowed: rigid, ambient, free, or {type: fluid" in words(termination="soft")
    assert "there is no such field; did you mean 'density'?" in words(termination={"type": "fluid", "densty": 1.0})


def test_what_each_termination_answers():
    def answer(termination):
        return plane_wave(stack({**AIR, "thickness": 1e-9}, termination=termination), 100.0)

    assert answer("rigid").reflection == pytest.approx(1)
    assert answer("free").reflection == pytest.approx(-1)
    assert answer("ambient").reflection == pytest.approx(0, abs=1e-8)
    assert answer("rigid").transmission is answer("rigid").transmission_loss is None
    assert answer("ambient").transmission_loss == pytest.approx(0, abs=1e-6)


# what has no response, and what cannot be asked


def test_nothing_gives_way_between_base_and_wall():
    with pytest.raises(InputError, match="the stack has no finite response here"):
        base_motion(stack(SHEET, termination="rigid"), [100.0, 200.0])


def test_a_sheet_on_a_wall_reflects_all():
    result = plane_wave(stack(SHEET, termination="rigid"), [100.0, 5e3], [0.0, 60.0])
    np.testing.assert_allclose(result.reflection, 1, rtol=1e-12)
    assert np.all(np.abs(result.surface_impedance) > 1e15)


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.inf, np.nan, [100.0, 0.0]])
def test_frequencies_that_are_none(frequency):
    with pytest.raises(InputError, match="frequencies must be above 0 Hz"):
        plane_wave(stack(AIR), frequency)


@pytest.mark.parametrize("angle", [90.0, -1.0, np.nan, [0.0, 120.0]])
def test_angles_that_are_none(angle):
    with pytest.raises(InputError, match="from 0 to below 90 degrees"):
        plane_wave(stack(AIR), 100.0, angle)


@pytest.mark.parametrize(("f", "a"), [((), ()), ((3,), ()), ((), (2,)), ((3,), (2,)), ((2, 2), (3,))])
def test_shapes_add_up(f, a):
    result = plane_wave(rubber_on_air(), np.full(f, 100.0), np.full(a, 30.0))
    for array in (result.reflection, result.absorption, result.surface_impedance):
        assert np.shape(array) == (*f, *a)


# files


def test_data_comes_back():
    panel = rubber_on_air(contacts=[{"between": ["skin", 3], "kind": "slip"}], termination={"type": "fluid"})
    assert Stack.model_validate(panel.to_dict()) == panel


def test_a_file(tmp_path):
    path = tmp_path / "stack.yaml"
    path.write_text("version: 1\nlayers:\n  - {type: fluid, thickness: 5 cm}\ntermination: rigid\n")
    assert load_stack(path) == stack(AIR, termination="rigid")
    path.write_text("version: 1\nlayers:\n  - {type: fluid, thickness: -5 cm}\ntermination: hard\n")
    with pytest.raises(InputError) as caught:
        load_stack(path)
    assert [(p.line, p.path) for p in caught.value.problems] == [(3, "layers.0.thickness"), (4, "termination")]


# layers that know of others


class Told(Fluid):
    """Notes what lies on it."""

    above: tuple[str, ...] = ()

    def under(self, above):
        return self.model_copy(update={"above": tuple(layer.name for layer in above)})

    def faces(self, wave):
        seen.append(self.above)
        return super().faces(wave)


seen: list[tuple[str, ...]] = []


@pytest.mark.parametrize("look", ["plane_wave", "base_motion", "fields", "power_balance"])
def test_layers_know_what_lies_on_them(look):
    layers = tuple(Told(name=name, thickness=0.1) for name in "abc")
    seen.clear()
    ask = {"plane_wave": plane_wave, "base_motion": base_motion, "fields": fields, "power_balance": power_balance}
    ask[look](Stack(layers=layers, termination="ambient"), [100.0, 200.0])
    on_a_wall, on_a_base = {(), ("a",), ("b", "a")}, {("b", "c"), ("c",), ()}
    assert set(seen) == (on_a_base if look == "base_motion" else on_a_wall)
