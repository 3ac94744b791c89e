"""Layer types, one per file, and their registry."""

from multilayer.layers.base import LAYERS, Layer, LayerField

__all__ = ["LAYERS", "Layer", "LayerField"]
