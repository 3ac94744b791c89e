"""
Absorption of a foam at several angles
======================================

Test.
"""

from multilayer import load_stack

print(load_stack("../foam_absorption.yaml").layers[0].name)
