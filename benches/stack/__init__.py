"""Stacks of BSDFs beside the BSDF of all layers traced together."""
