"""Lets the tests run before the package is installed, too."""

import multilayer_anisotropic

from multilayer.testing import use_module

use_module(multilayer_anisotropic)
