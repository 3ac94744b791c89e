"""Simulations that tests run."""

FOAM = """\
version: 1
layers:
  - type: poroelastic
    name: foam
    thickness: 50 mm
    porosity: 0.98
    flow_resistivity: 15e3
    tortuosity: 1.05
    viscous_length: 100 um
    thermal_length: 250 um
    frame_density: 25
    young_modulus: {law: loss_factor, young_modulus: 140 kPa, loss_factor: 0.1}
    poisson_ratio: 0.3
termination: rigid
"""
_PLATE = "thickness: 1 mm, density: 2700, young_modulus: 70 GPa, poisson_ratio: 0.33, loss_factor: 0.01"
PANEL = f"""\
version: 1
layers:
  - {{type: elastic_plate, name: plate, {_PLATE}}}
  - {{type: fluid, name: gap, thickness: 50 mm}}
  - {{type: elastic_plate, name: back, {_PLATE}}}
termination: ambient
"""
FOAM_BESIDE_CHAMBER = """\
version: 1
layers:
  - type: patches
    name: mix
    period: 60 mm
    patches:
      - name: foam
        share: 70 %
        layers: [{type: equivalent_fluid, model: miki, thickness: 50 mm, flow_resistivity: 10 kN s/m^4}]
      - {name: chamber, share: 30 %, closed: true, layers: [{type: fluid, thickness: 200 mm}]}
termination: rigid
frequency: [400, 1000]
"""
