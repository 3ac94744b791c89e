"""Files to spoil: our examples, and short ones that use what the examples do not."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np

EXAMPLES = Path(__file__).parents[2] / "examples"
_KEPT_BURSTS = 2

_MADE = {
    "panel.yaml": """\
kind: simulation
version: 1
ambient: {temperature: 21 degC, pressure: 100 kPa, relative_humidity: 0.4}
layers:
  - {type: elastic_solid, name: steel, thickness: 1 mm, density: 7800, young_modulus: 210 GPa, poisson_ratio: 0.3}
  - {type: poroelastic, name: foam, thickness: 30 mm, porosity: 0.99, flow_resistivity: 1e4, tortuosity: 1.01,
     viscous_length: 100 um, thermal_length: 200 um, frame_density: 9, young_modulus: "1.6e5+2e4j Pa",
     poisson_ratio: 0.4}
  - {type: screen, flow_resistivity: 1e6, thickness: 0.5 mm, surface_density: 0.2}
  - {type: fluid, thickness: 10 mm}
  - {type: membrane, surface_density: 0.3, tension: 5000, loss_factor: 0.1}
  - {type: limp, model: jcal, thickness: 20 mm, porosity: 0.98, flow_resistivity: 2e4, tortuosity: 1.1,
     viscous_length: 80 um, thermal_length: 150 um, thermal_permeability: 6e-9, frame_density: 30}
  - {type: elastic_plate, name: board, thickness: 12 mm, density: 700, poisson_ratio: 0.2,
     young_modulus: {law: zener, relaxed_modulus: 3e9, unrelaxed_modulus: 4e9, relaxation_time: 1e-4}}
contacts:
  - {between: [steel, foam], kind: slip}
termination: {type: fluid, density: 1.2, sound_speed: 343}
frequency: {from: 100 Hz, to: 5 kHz, points: 7}
incidence: 30
finite_size: {width: 1 m, height: 2 m}
sweep: {layers.foam.thickness: [10 mm, 20 mm], ambient.temperature: [0 degC, 20 degC]}
""",
    "laws.yaml": """\
version: 1
layers:
  - {type: elastic_solid, thickness: 5 mm, density: 1200, poisson_ratio: 0.3, young_modulus: {law: havriliak_negami,
     relaxed_modulus: 1e6, unrelaxed_modulus: 1e9, relaxation_time: 1 us, order: 0.5, asymmetry: 0.7}}
  - {type: elastic_solid, thickness: 5 mm, density: 1200, poisson_ratio: 0.3, young_modulus: {law: maxwell,
     relaxed_modulus: 1e6, branch_modulus: [1e6, 2e6], relaxation_time: [1 ms, 1 us]}}
  - {type: elastic_solid, thickness: 5 mm, density: 1200, poisson_ratio: 0.3, young_modulus: {law: table,
     frequency: [10, 1000, 10000], storage_modulus: [1e6, 2e6, 3e6], loss_modulus: [1e5, 2e5, 3e5]}}
  - {type: elastic_solid, thickness: 5 mm, density: 1200, poisson_ratio: 0.3, young_modulus: {law: kelvin_voigt,
     young_modulus: 1e6, viscosity: 10}}
  - {type: equivalent_fluid, model: wilson, thickness: 5 cm, porosity: 0.98, tortuosity: 1.05, vorticity_time: 1e-4,
     entropy_time: 2e-4}
  - {type: viscothermal_fluid, thickness: 3 cm, tube_radius: 0.3 mm, open_area: 0.8}
  - {type: perforated_plate, model: maa, thickness: 0.2 mm, hole_radius: 0.1 mm, perforation: 0.01}
termination: ambient
frequency: [100, 500 Hz, 1 kHz]
tolerances: {layers.0.thickness: 5 %, layers.4.porosity: {uniform: [0.9, 0.99]}}
samples: 5
seed: 3
""",
    "wood.yaml": """\
version: 1
layers:
  - {type: orthotropic_plate, thickness: 10 mm, density: 450, young_modulus_x: 11 GPa, young_modulus_y: 500 MPa,
     poisson_ratio_xy: 0.4, shear_modulus_xy: 700 MPa, loss_factor: 0.02, azimuth: 30}
termination: ambient
frequency: {octaves: [500 Hz, 1 kHz]}
incidence: 45
reference: {version: 1, layers: [{type: fluid, thickness: 1 mm}], termination: ambient}
""",
    "diffuse.yaml": """\
version: 1
layers:
  - {material: AA2009/T11.3/foam, thickness: 3 cm}
  - {type: fluid, thickness: 5 mm}
termination: rigid
frequency: [200, 1000]
incidence: {diffuse: {max_angle: 70, weighting: gaussian}}
""",
    "soft.yaml": """\
version: 1
layers:
  - {type: poroelastic, name: foam, thickness: 4 cm, porosity: 0.97, flow_resistivity: 1e4, tortuosity: 1.1,
     viscous_length: 100 um, thermal_length: 200 um, frame_density: 20, young_modulus: 1e5, loss_factor: 0.1,
     poisson_ratio: 0.3}
""",
    "library.yaml": """\
kind: library
version: 1
materials:
  our_foam: {source: lot 7, note: soft, type: poroelastic, porosity: 0.98, flow_resistivity: 12 kN s/m^4}
  board: {type: elastic_plate, density: 700, young_modulus: 3e9, poisson_ratio: 0.2}
""",
    "calibration.yaml": """\
kind: calibration
version: 1
rig: calibration
sampling_rate: 25600
burst: {cycles: 10, window: hann, level_rms: 5.0}
bursts:
  - {frequency: 100, file: signals/h25mm-t1mm_0100Hz.npz}
""",
    "law.yaml": """\
kind: rig-law
version: 1
effects:
  - {effect: sensor_mass, parameters: {mass: {value: 1e-3, low: 0.8e-3, high: 1.2e-3}}}
laws:
  - {place: top_plate, unit: kg, table: {frequency_hz: [100, 1000], real: [1, 2], real_low: [0, 1], real_high: [2, 3],
     imag: [0, 0], imag_low: [-1, -1], imag_high: [1, 1]}}
""",
}
_DIAGNOSE = """\
kind: diagnose
version: 1
nominal: foam.yaml
measurements:
  - {kind: reflection, file: tube.csv, noise: 0.02, from: 200 Hz, to: 4 kHz}
unknowns:
  layers.foam.flow_resistivity: {lognormal: [2.0e4, 0.5]}
effects: all
tube: {microphone_spacing: 50 mm, microphone_distance: 100 mm, diameter: 100 mm, error: 0.01, length: 0.3}
"""
_STACK_FIT = """\
kind: stack-fit
version: 1
stacks: {a: ../soft.yaml}
measurements:
  - {kind: reflection, stack: a, file: tube.csv, noise: {relative: 0.02, absolute: 0.01},
     columns: {frequency: frequency_hz}}
  - {kind: stiffness, stack: a, layer: foam, radius: 2 cm, frequency: 5 Hz, stiffness: 1e4+1e3j N/m, noise: 0.05}
unknowns:
  stiffness of the frame: {paths: [layers.foam.young_modulus], loguniform: [1 kPa, 1 MPa]}
  layers.foam.thickness: {normal: [4 cm, 1 mm]}
search: {candidates: 8, starts: 2, seed: 1}
"""


def write_corpus(folder: Path) -> list[Path]:
    """Write a folder with all files and their data, and return the YAML files to be spoiled."""
    for name in ("foam_tube", "raw_tube", "foam_b"):
        shutil.copytree(EXAMPLES / name, folder / name)
    for file in EXAMPLES.glob("*.yaml"):
        shutil.copy(file, folder / file.name)
    _keep_few_bursts(folder / "foam_b" / "campaign.yaml")
    for name, text in _MADE.items():
        home = folder / "foam_b" if name == "calibration.yaml" else folder
        (home / name).write_text(text, encoding="utf-8")
    (folder / "foam_tube" / "diagnose.yaml").write_text(_DIAGNOSE, encoding="utf-8")
    (folder / "foam_tube" / "stacks.yaml").write_text(_STACK_FIT, encoding="utf-8")
    _four_microphones(folder / "raw_tube")
    return sorted(folder.rglob("*.yaml"))


def _keep_few_bursts(file: Path) -> None:
    """Leave a campaign few bursts: checking reads them all."""
    lines, kept, seen = file.read_text(encoding="utf-8").splitlines(), [], 0
    for line in lines:
        if re.search(r"- \{frequency: \d+, file", line):
            seen += 1
            if seen > _KEPT_BURSTS:
                continue
        kept.append(line)
    file.write_text("\n".join(kept) + "\n", encoding="utf-8")


def _four_microphones(folder: Path) -> None:
    """Write a table of four microphones, and the file that describes the tube."""
    f = np.arange(200.0, 1700.0, 100.0)
    columns = ["frequency_hz", *(f"h{i}_{part}" for i in (1, 2, 3, 4) for part in ("re", "im"))]
    k = 2 * np.pi * f / 343
    pressures = [np.exp(-1j * k * x) + 0.4 * np.exp(1j * k * x) for x in (-0.15, -0.1)]
    pressures += [0.5 * np.exp(-1j * k * (x - 0.02)) for x in (0.1, 0.15)]
    rows = np.column_stack([f, *(part for p in pressures for part in (p.real, p.imag))])
    body = "\n".join(",".join(f"{value:.9g}" for value in row) for row in rows)
    (folder / "four.csv").write_text(f"{','.join(columns)}\n{body}\n", encoding="utf-8")
    (folder / "four.yaml").write_text(
        "version: 1\nmethod: four_microphones\ntube: {width: 40 mm, height: 40 mm, attenuation: kirchhoff}\n"
        "positions: [-0.15, -0.1, 0.1, 0.15]\nthickness: 20 mm\nloads: [{file: four.csv}]\nfrom: 200 Hz\nto: 1600 Hz\n",
        encoding="utf-8",
    )
