"""JSON Schemas: true to the models, true to every example, and hard on typical mistakes."""

import json
import re
from pathlib import Path

import jsonschema
import pytest

from multilayer.config.yaml12 import parse_yaml, read_yaml
from multilayer.errors import InputError
from multilayer.json_text import json_text
from multilayer.kinds import KINDS, kind_named, kind_of
from multilayer.layers.base import LAYERS, LayerField
from multilayer.layers.fluid import Fluid
from multilayer.materials import BUILT_IN
from multilayer.media.laws import LAWS
from multilayer.registry import Registry
from multilayer.units import Length
from tests.contract.samples import LAYER_SAMPLES

ROOT = Path(__file__).parents[2]
SCHEMAS = ROOT / "docs" / "schemas"
EXAMPLES = sorted((ROOT / "examples").rglob("*.yaml"))
LINE = re.compile(r"# yaml-language-server: \$schema=(\S+)\n")
BLOCK = re.compile(r"```yaml\n(.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def checkers():
    return {name: jsonschema.Draft7Validator(kind.schema()) for name, kind in KINDS.items()}


def mistakes(checker, data):
    return [error.message for error in checker.iter_errors(data)]


@pytest.fixture
def only_own(monkeypatch):
    """Hide what other packages registered: the schemas in the repository are of what it has itself."""
    names = Registry.names

    def own(self):
        return [name for name in names(self) if str(self.origins(name)[0]).startswith("multilayer.")]

    monkeypatch.setattr(Registry, "names", own)


@pytest.mark.parametrize("name", KINDS)
def test_schemas_are_schemas(name):
    schema = KINDS[name].schema()
    jsonschema.Draft7Validator.check_schema(schema)
    assert json.loads(json_text(schema)) == schema


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: str(file.relative_to(ROOT / "examples")))
def test_example_names_its_schema_and_fits_it(file, checkers):
    named = LINE.match(file.read_text())
    kind = kind_of(file)
    assert (file.parent / named[1]).resolve() == SCHEMAS / f"{kind.name}.json"
    assert mistakes(checkers[kind.name], read_yaml(file).data) == []


def test_library_fits_its_schema(checkers):
    assert mistakes(checkers["library"], read_yaml(BUILT_IN).data) == []


def test_shared_campaigns_fit_their_schema(shared, checkers):
    files = sorted(shared.glob("campaigns/*/*.yaml"))
    assert files
    for file in files:
        assert mistakes(checkers[kind_of(file).name], read_yaml(file).data) == [], file


def test_files_in_the_documentation_fit_their_schemas(checkers, tmp_path):
    pages = [page for page in sorted((ROOT / "docs").glob("*.md")) if page.name != "messages.md"]  # wrong on purpose
    found = [block for page in pages for block in BLOCK.findall(page.read_text())]
    whole = [block for block in found if re.search(r"^version: 1", block, re.MULTILINE)]
    assert len(whole) > 8
    for block in whole:
        (tmp_path / "file.yaml").write_text(block)
        kind = kind_of(tmp_path / "file.yaml")
        assert mistakes(checkers[kind.name], parse_yaml(block, Path("page")).data) == [], block


def plain(fields):
    """Return sample fields as a file holds them."""
    return {key: f"{v.real}+{v.imag}j Pa" if isinstance(v, complex) else v for key, v in fields.items()}


@pytest.mark.parametrize(
    ("kind", "fields"),
    [(kind, fields) for kind, samples in LAYER_SAMPLES.items() for _, fields, _ in samples],
    ids=[f"{kind}: {what}" for kind, samples in LAYER_SAMPLES.items() for what, _, _ in samples],
)
def test_what_a_layer_takes_its_schema_takes(kind, fields, checkers):
    layer = plain(fields) | {"type": kind}
    assert mistakes(checkers["stack"], {"version": 1, "layers": [layer]}) == []
    assert mistakes(checkers["stack"], {"version": 1, "layers": [layer | {"colour": "red"}]})


FOAM = {
    "type": "equivalent_fluid", "name": "foam", "thickness": "50 mm", "porosity": 0.98, "flow_resistivity": 1e4,
    "tortuosity": 1.02, "viscous_length": "100 um", "thermal_length": "0.2 mm",
}  # fmt: skip
PLATE = {"type": "elastic_plate", "thickness": 1e-3, "density": 2700, "young_modulus": "70 GPa", "poisson_ratio": 0.3}
STACK = {"version": 1, "layers": [FOAM, PLATE], "termination": "rigid"}
CAMPAIGN = read_yaml(ROOT / "examples" / "foam_b" / "campaign.yaml").data
FIT = {"version": 1, "campaign": "."}
TUBE = read_yaml(ROOT / "examples" / "foam_tube" / "fit.yaml").data
RAW = read_yaml(ROOT / "examples" / "raw_tube" / "tube.yaml").data
RIG = read_yaml(ROOT / "examples" / "virtual_rig.yaml").data


def layer(**changes):
    return {**STACK, "layers": [{**FOAM, **changes}]}


def plate(**changes):
    return {**STACK, "layers": [{**PLATE, **changes}]}


def measured(**changes):
    return {**TUBE, "measurements": [{**TUBE["measurements"][0], **changes}]}


def unknown(said):
    return {**TUBE, "unknowns": {"layers.foam.porosity": said}}


RIGHT = [
    ("stack", STACK),
    ("stack", {**STACK, "ambient": {"temperature": "-5 degC"}, "termination": {"type": "fluid", "density": 1000}}),
    ("stack", {**STACK, "library": "ours.yaml", "layers": [{"material": "glass_wool", "thickness": "4 cm"}]}),
    ("stack", {**STACK, "contacts": [{"between": ["foam", 1], "kind": "slip"}]}),
    ("stack", plate(young_modulus="7e10+1e9j Pa")),
    ("stack", plate(young_modulus="(70 + 1 j) GPa")),
    ("stack", plate(young_modulus="70 J/cm^3")),
    ("stack", plate(young_modulus={"law": "loss_factor", "young_modulus": "70 GPa", "loss_factor": "1 %"})),
    ("stack", plate(young_modulus={"law": "table", "file": "e.csv"})),
    ("simulation", {**STACK, "frequency": [100, "1 kHz"], "incidence": "45 deg"}),
    ("simulation", {**STACK, "frequency": {"third_octaves": ["100 Hz", 5000]}, "incidence": {"diffuse": {}}}),
    ("simulation", {**STACK, "reference": "empty.yaml", "sweep": {"layers.0.thickness": ["1 cm", 0.02]}}),
    ("simulation", {**STACK, "reference": STACK}),
    ("fit", {**FIT, "model": "finite", "pores": {"porosity": "98 %", "flow_resistivity": "10 kN s/m^4"}}),
    ("stack-fit", measured(noise="2 %", model_error=0.01)),
    ("stack-fit", measured(kind="absorption", bands="third octaves", noise=0.02)),
    ("stack-fit", unknown({"paths": "layers.foam.porosity", "uniform": [0.9, 1]})),
    ("diagnose", {**TUBE, "effects": ["facing", "temperature"], "tube": {}}),
    ("diagnose", {**TUBE, "effects": "facing"}),
    ("tube", {**RAW, "tube": {"width": "4 cm", "height": 0.03}, "from": "200 Hz"}),
    ("rig", RIG),
    ("library", {"version": 1, "materials": {"ours": {"type": "fluid", "source": "a book"}}}),
]


@pytest.mark.parametrize(("kind", "data"), RIGHT)
def test_what_is_right_is_taken(kind, data, checkers):
    assert mistakes(checkers[kind], data) == []


WRONG = {
    "no such layer type": ("stack", layer(type="foam")),
    "no such field": ("stack", layer(poroosity=0.9)),
    "a field missing": ("stack", {**STACK, "layers": [{key: FOAM[key] for key in FOAM if key != "porosity"}]}),
    "a field of another model": ("stack", layer(thermal_permeability=1e-9)),
    "the model's field missing": ("stack", layer(model="jcal")),
    "no such model": ("stack", layer(model="jcb")),
    "below 0": ("stack", layer(thickness=-0.05)),
    "below 0 with a unit": ("stack", layer(thickness="-50 mm")),
    "above the limit": ("stack", layer(porosity=1.2)),
    "no number": ("stack", layer(thickness="thick")),
    "a list for a number": ("stack", layer(thickness=[0.05])),
    "a number for a name": ("stack", layer(name=5)),
    "no layers": ("stack", {"version": 1, "layers": []}),
    "layers missing": ("stack", {"version": 1, "layres": [FOAM]}),
    "another version": ("stack", {**STACK, "version": 2}),
    "no such end": ("stack", {**STACK, "termination": "rigidd"}),
    "no such law": ("stack", plate(young_modulus={"law": "zenner"})),
    "a law's field missing": ("stack", plate(young_modulus={"law": "zener", "relaxed_modulus": 1e5})),
    "no modulus": ("stack", plate(young_modulus="stiff")),
    "the imaginary part first": ("stack", plate(young_modulus="2e4j+1e5 Pa")),
    "no real part": ("stack", plate(young_modulus="2e4j Pa")),
    "a table without values": ("stack", plate(young_modulus={"law": "table"})),
    "a contact of three": ("stack", {**STACK, "contacts": [{"between": [0, 1, 2], "kind": "slip"}]}),
    "no such contact": ("stack", {**STACK, "contacts": [{"between": [0, 1], "kind": "glued"}]}),
    "a simulation's key in a stack": ("stack", {**STACK, "incidence": "normal"}),
    "a misspelt field beside a material": ("stack", {**STACK, "layers": [{"material": "glass_wool", "thicknes": 1}]}),
    "no such incidence": ("simulation", {**STACK, "incidence": "grazing"}),
    "an angle too large": ("simulation", {**STACK, "incidence": 90}),
    "two kinds of bands": (
        "simulation",
        {**STACK, "frequency": {"octaves": [125, 4000], "third_octaves": [100, 5000]}},
    ),
    "a range misspelt": ("simulation", {**STACK, "frequency": {"from": 100, "until": 5000}}),
    "one sample": ("simulation", {**STACK, "samples": 1}),
    "no such method": ("fit", {**FIT, "method": "simplex"}),
    "bounds of one": ("fit", {**FIT, "bounds": {"storage_modulus": ["1 kPa"]}}),
    "no such rig": ("campaign", {**CAMPAIGN, "rig": "shaker"}),
    "no configurations": ("campaign", {**CAMPAIGN, "configurations": []}),
    "no top plate": ("campaign", {key: CAMPAIGN[key] for key in CAMPAIGN if key != "top_plate"}),
    "no such measurement": ("stack-fit", measured(kind="reflexion")),
    "two priors": ("stack-fit", unknown({"uniform": [0, 1], "normal": [0.5, 0.1]})),
    "no prior": ("stack-fit", unknown({"nuisance": True})),
    "no stack": ("stack-fit", {key: TUBE[key] for key in TUBE if key != "nominal"}),
    "no such effect": ("diagnose", {**TUBE, "effects": ["facings"]}),
    "a tube's method unknown": ("tube", {**RAW, "method": "one_microphone"}),
    "a field of the other method": ("tube", {**RAW, "positions": [-0.2, -0.1, 0.1, 0.2]}),
    "no such effect of the rig": ("rig", {**RIG, "effects": [{"effect": "sensor_masses"}]}),
    "a field that the effect has not": ("rig", {**RIG, "effects": [{"effect": "sensor_mass", "weight": 1}]}),
    "no number of repeats": ("rig", {**RIG, "repeats": 0}),
}


@pytest.mark.parametrize("name", WRONG)
def test_typical_mistakes_are_refused(name, checkers):
    kind, data = WRONG[name]
    assert mistakes(checkers[kind], data)


class Felt(LAYERS["fluid"]):
    """A layer of a plugin."""

    type: str = "felt"
    thickness: Length


def test_layers_of_plugins_are_in_the_schema():
    LAYERS.register("felt", Felt)
    try:
        checker = jsonschema.Draft7Validator(kind_named("stack").schema())
    finally:
        LAYERS.unregister("felt")
    assert mistakes(checker, {"version": 1, "layers": [{"type": "felt", "thickness": "3 mm"}]}) == []
    assert mistakes(checker, {"version": 1, "layers": [{"type": "felt", "thickness": "3 mm", "colour": 1}]})
    assert mistakes(checker, {"version": 1, "layers": [{"type": "felt"}]})


def test_a_layer_may_hold_layers():
    class Sandwich(LAYERS["fluid"]):
        type: str = "sandwich"
        core: LayerField

    LAYERS.register("sandwich", Sandwich)
    try:
        checker = jsonschema.Draft7Validator(kind_named("stack").schema())
    finally:
        LAYERS.unregister("sandwich")
    fluid = {"type": "fluid", "thickness": "3 mm"}
    assert mistakes(checker, {"version": 1, "layers": [{**fluid, "type": "sandwich", "core": fluid}]}) == []
    wrong = {**fluid, "type": "sandwich", "core": {**fluid, "colour": 1}}
    assert mistakes(checker, {"version": 1, "layers": [wrong]})


def test_laws_of_plugins_are_in_the_schema():
    class Rubber(LAWS["constant"]):
        law: str = "rubber"

    LAWS.register("rubber", Rubber)
    try:
        checker = jsonschema.Draft7Validator(kind_named("stack").schema())
    finally:
        LAWS.unregister("rubber")
    fields = {name: 1e5 for name in Rubber.model_fields if name != "law"}
    assert mistakes(checker, plate(young_modulus={"law": "rubber", **fields})) == []
    assert mistakes(checker, plate(young_modulus={"law": "rubber", **fields, "softness": 1}))


def test_quantities_say_their_unit():
    schema = Fluid.model_json_schema()
    assert schema["properties"]["thickness"]["description"] == "In m: 0.05 or '50 mm'."


def test_kinds_are_told_apart(tmp_path):
    with pytest.raises(InputError, match=r"there is no kind of file 'stacks'; did you mean 'stack'\?"):
        kind_named("stacks")
    file = tmp_path / "file.yaml"
    for text, kind in (("layrs: []", "stack"), ("unknowms: {}", "stack-fit"), ("rig: calibration", "calibration")):
        file.write_text(text)
        assert kind_of(file).name == kind
    # what a file says of itself goes before its keys
    file.write_text("kind: tube\nlayers: []")
    assert kind_of(file).name == "tube"
    file.write_text("version: 1\nkind: stak\nlayers: []")
    with pytest.raises(InputError, match=r"2:7: kind: there is no kind of file 'stak'; did you mean 'stack'\?"):
        kind_of(file)
    file.write_text("something: else")
    with pytest.raises(InputError, match="nothing in this file tells what it is"):
        kind_of(file)
