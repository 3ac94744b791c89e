"""Pure formulae of media: gases, pores, elastic moduli, Biot waves; each with its source."""
