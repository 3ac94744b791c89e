"""One modulus law for all bursts of a campaign."""
