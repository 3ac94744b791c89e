"""Pure formulae of media: gases, pores, elastic moduli, Biot waves; each with its source.

Throughout the package, Allard & Atalla 2009 is J. F. Allard & N. Atalla, Propagation of Sound in Porous Media, 2nd ed.,
Wiley 2009; Bonfiglio & Pompoli 2015 is P. Bonfiglio & F. Pompoli, Polymer Testing 48 (2015) 89-96.
"""
