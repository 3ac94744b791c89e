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
# what lies beside a stack, ties its leaves together, acts on it, is searched in it, is measured of it as levels: under
# a folder of their own, so that `--files 'walls/*'` takes these alone
_WALLS = {
    "studs.yaml": """\
kind: simulation
version: 1
layers:
  - {type: elastic_plate, name: front, thickness: 12.5 mm, density: 700, young_modulus: 3 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
  - {type: limp, name: wool, thickness: 75 mm, porosity: 0.98, flow_resistivity: 8e3, tortuosity: 1.0,
     viscous_length: 120 um, thermal_length: 240 um, frame_density: 16}
  - {type: elastic_plate, name: back, thickness: 12.5 mm, density: 700, young_modulus: 3 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
termination: ambient
links:
  - {name: studs, kind: line, between: [front, back], spacing: 0.6 m, compliance: 1e-6 m2/N}
  - {name: ties, kind: point, between: [front, back], spacing: 40 cm}
area: 10 m2
beside:
  - {type: slit, name: joint, width: 0.1 mm, length: 8 m, depth: 100 mm, at_edge: true}
  - {type: hole, radius: 5 mm, depth: 150 mm, count: 3}
  - {type: flanking, name: floor, transmission_loss: 60 dB}
frequency: [125, 500 Hz, 2 kHz]
incidence: 45
sweep: {links.studs.compliance: [0, 1e-6 m2/N], beside.joint.width: [0.1 mm, 1 mm]}
tolerances: {links.ties.spacing: 5 %, area: 1 m2}
samples: 3
""",
    "screws.yaml": """\
kind: simulation
version: 1
layers:
  - {type: elastic_plate, name: front, thickness: 12.5 mm, density: 700, young_modulus: 3 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
  - {type: fluid, thickness: 9 cm}
  - {type: elastic_plate, name: back, thickness: 12.5 mm, density: 700, young_modulus: 3 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
termination: ambient
links:
  - {name: studs, kind: line, between: [front, back], spacing: 0.4 m, periodic: true, fasteners: 30 cm}
frequency: [100, 250 Hz]
incidence: 45
sweep: {links.studs.fasteners: [0.2 m, 0.3 m]}
""",
    "window.yaml": """\
kind: simulation
version: 1
layers:
  - {material: Bauakustik/T4.2.4-1/concrete, name: concrete, thickness: 150 mm}
termination: ambient
area: 10 m2
beside:
  - type: patch
    name: window
    area: 1.5 m2
    stack:
      layers: [{material: Bauakustik/T4.2.4-1/glass, thickness: 6 mm}]
      termination: ambient
  - {type: patch, name: door, width: 0.9 m, height: 2 m, stack: board.yaml}
  - {type: flanking, spectrum: {frequency: [100, 1000, 3150 Hz], transmission_loss: [50, 55, 60 dB]}}
frequency: {octaves: [500 Hz, 1 kHz]}
incidence: {diffuse: {max_angle: 70}}
finite_size: {width: 4 m, height: 2.5 m}
sweep: {beside.window.stack.layers.0.thickness: [4 mm, 6 mm]}
""",
    "board.yaml": """\
version: 1
layers:
  - {type: elastic_plate, name: board, thickness: 12.5 mm, density: 700, young_modulus: 2.5e9, poisson_ratio: 0.3,
     loss_factor: 0.02}
termination: ambient
""",
    "mosaic.yaml": """\
kind: simulation
version: 1
layers:
  - type: patches
    name: mosaic
    period: 60 mm
    patches:
      - {name: foam, share: 70 %, layers: [{type: equivalent_fluid, model: miki, thickness: 50 mm,
         flow_resistivity: 10 kN s/m^4}]}
      - name: chamber
        share: 30 %
        closed: true
        layers: [{type: screen, flow_resistance: 400}, {type: fluid, thickness: 200 mm}]
  - {type: fluid, thickness: 20 mm}
termination: rigid
frequency: [100, 400, 1000]
incidence: 30
sweep: {layers.mosaic.patches.0.layers.0.thickness: [50 mm, 40 mm]}
""",
    "tapped.yaml": """\
kind: simulation
version: 1
layers:
  - {type: elastic_plate, name: screed, thickness: 50 mm, density: 2000, young_modulus: 20 GPa, poisson_ratio: 0.2,
     loss_factor: 0.03}
  - {type: elastic_solid, name: mat, thickness: 20 mm, density: 100, young_modulus: 0.4 MPa, poisson_ratio: 0.1,
     loss_factor: 0.1}
  - {type: elastic_plate, name: slab, thickness: 140 mm, density: 2300, young_modulus: 30 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
termination: ambient
excitation: {type: tapping_machine, restitution: 0.5, hammer_mass: 500 g, fall_height: 4 cm, blows_per_second: 10 Hz,
  radius: 15 mm}
free_waves: true
frequency: [100, 1000]
sweep: {excitation.restitution: [0, 1]}
""",
    "silencer.yaml": """\
kind: simulation
version: 1
layers:
  - {type: screen, flow_resistance: 100}
  - {type: equivalent_fluid, name: wool, model: miki, thickness: 50 mm, flow_resistivity: 8 kN s/m^4}
termination: rigid
duct: {height: 100 mm, lined: one side, mach: -0.05}
frequency: [200, 2000 Hz]
sweep: {duct.height: [0.1, 200 mm]}
""",
    "roof.yaml": """\
kind: simulation
version: 1
layers:
  - {type: elastic_plate, thickness: 0.7 mm, density: 7800, young_modulus: 210 GPa, poisson_ratio: 0.3,
     loss_factor: 0.01}
termination: ambient
excitation: {type: rain, rate: 40 mm/h, drop_diameter: 5 mm, fall_velocity: 7 m/s, water_density: 1000}
finite_size: {width: 1.4 m, height: 1.1 m}
frequency: [200, 1300 Hz]
tolerances: {layers.0.thickness: 0.1 mm}
samples: 2
""",
    "hull.yaml": """\
kind: simulation
version: 1
layers:
  - {type: elastic_plate, name: skin, thickness: 2 mm, density: 2700, young_modulus: 70 GPa, poisson_ratio: 0.33,
     loss_factor: 0.02}
  - {material: AA2009/T11.3/foam, thickness: 3 cm}
termination: ambient
excitation: {type: turbulent_flow, speed: 50 m/s, boundary_layer_thickness: 20 mm, friction_velocity: 1.8 m/s,
  convection: 0.7, decay_along: 0.116, decay_across: 0.7}
frequency: [500, 2000]
""",
    "struck.yaml": """\
kind: simulation
version: 1
layers:
  - {type: elastic_plate, thickness: 10 mm, density: 2500, young_modulus: 60 GPa, poisson_ratio: 0.2,
     loss_factor: 0.02}
termination: ambient
excitation: {type: point_force, spectral_density: 2, radius: 10 mm}
frequency: {third_octaves: [500 Hz, 630 Hz]}
""",
    "design.yaml": """\
kind: optimisation
version: 1
layers:
  - {name: front, material: AA2009/T11.3/foam, thickness: 20 mm}
  - {name: back, material: AA2009/T11.3/foam, thickness: 20 mm}
  - {type: fluid, name: gap, thickness: 5 mm}
termination: rigid
frequency: [250, 500, 1000]
design:
  layers.front.material: {among: [AA2009/T11.3/foam, AA2009/T11.6/foam]}
  layers.back.thickness: [5 mm, 45 mm]
  layers.gap.thickness: [2 mm, 40 mm]
  optional: [gap]
goal: {highest: absorption, from: 200 Hz, to: 1 kHz}
limits:
  - {of: thickness, at_most: 50 mm}
  - {of: mass, at_most: 1.5 kg/m^2}
search: {starts: 1, seed: 0}
""",
    "front.yaml": """\
kind: optimisation
version: 1
layers:
  - {type: elastic_plate, name: board, thickness: 10 mm, density: 700, young_modulus: 3 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
  - {type: limp, name: wool, thickness: 50 mm, porosity: 0.98, flow_resistivity: 8e3, tortuosity: 1.0,
     viscous_length: 120 um, thermal_length: 240 um, frame_density: 16}
termination: ambient
frequency: [125, 500]
design:
  layers.board.thickness: [6 mm, 20 mm]
  layers.wool.flow_resistivity: [5 kN s/m^4, 50 kN s/m^4]
  order: [board, wool]
goal:
  - {highest: transmission_loss, from: 125 Hz, to: 500 Hz}
  - {lowest: price}
  - {closest: loss.csv, quantity: transmission_loss}
limits:
  - {of: transmission_loss, at_least: 5 dB, from: 400 Hz, to: 600 Hz}
catalogue:
  board: {price_per_mass: 2}
  wool: {price_per_volume: 100, mass: 1 kg/m^2}
search: {starts: 1}
""",
    "loss.yaml": """\
kind: diagnose
version: 1
nominal: board.yaml
measurements:
  - {kind: transmission_loss, file: loss.csv, bands: third octaves, incidence: diffuse}
unknowns:
  layers.board.density: {normal: [700 kg/m^3, 7 kg/m^3]}
effects: [receiving_absorption, leak]
uncertainty: repeatability
search: {candidates: 4, starts: 1}
""",
    "room.yaml": """\
kind: diagnose
version: 1
stacks: {wool: {version: 1, layers: [{type: equivalent_fluid, name: wool, model: miki, thickness: 50 mm,
  flow_resistivity: 8e3}], termination: rigid}}
measurements:
  - {kind: reverberation_absorption, stack: wool, file: room.csv, finite_size: {width: 3 m, height: 3.6 m}}
unknowns:
  wool.layers.wool.flow_resistivity: {lognormal: [8 kN s/m^4, 0.2]}
effects: [panel_size, limit_angle]
uncertainty: in_situ
search: {candidates: 4, starts: 1}
""",
    "alpha.yaml": """\
kind: diagnose
version: 1
nominal: wool.yaml
measurements:
  - {kind: absorption, file: room.csv, incidence: {diffuse: {max_angle: 80}}, bands: third octaves, noise: {absolute:
     0.02}, model_error: 0.01, from: 200 Hz, to: 2 kHz}
unknowns:
  layers.wool.thickness: {normal: [50 mm, 1 mm]}
effects: [rear_air_gap]
search: {candidates: 4, starts: 1}
""",
    "wool.yaml": """\
version: 1
layers:
  - {type: equivalent_fluid, name: wool, model: miki, thickness: 50 mm, flow_resistivity: 8e3}
termination: rigid
""",
}
_FOAMS = """\
Material,sigma [kN s/m4],phi,alpha_inf,Lambda [um],Lambda' [um],rho_s [kg/m3],N [kPa],nu,eta,k0' [m2],Comment
melamine,12,0.99,1.02,100,200,,,,,,light
"felt, grey",30,95 %,1.1,60,150,1200,50,0.3,0.1,4e-9,"of 3 lots"
=wool,2.5e1,0.97,1.0,80 um,160,2500,,,,,
"""
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
    _write_walls(folder / "walls")
    _four_microphones(folder / "raw_tube")
    return sorted(folder.rglob("*.yaml"))


def write_tables(folder: Path) -> list[Path]:
    """Write tables of materials, as other programs have them: by commas, by semicolons, by tabs."""
    folder.mkdir(parents=True)
    plain = _FOAMS.replace("felt, grey", "felt").replace('"', "")
    texts = {"comma": _FOAMS, "semicolon": plain.replace(",", ";").replace(".", ","), "tab": plain.replace(",", "\t")}
    for name, text in texts.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return sorted(folder.iterdir())


def _write_walls(folder: Path) -> None:
    """Write walls, what acts on them and what is searched or measured of them, with the levels that were measured."""
    folder.mkdir()
    for name, text in _WALLS.items():
        (folder / name).write_text(text, encoding="utf-8")
    bands = (200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000)
    for name, column, levels in (
        ("loss", "transmission_loss_db", [20 + 0.9 * i for i in range(len(bands))]),
        ("room", "absorption", [0.3 + 0.07 * i for i in range(len(bands))]),
    ):
        rows = "".join(f"{f},{level:.2f}\n" for f, level in zip(bands, levels, strict=True))
        (folder / f"{name}.csv").write_text(f"frequency_hz,{column}\n{rows}", encoding="utf-8")


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
