"""YAML text to models and back, every mistake with its file, line and column."""

from multilayer.config.validate import read
from multilayer.config.yaml12 import Document, dump_yaml, parse_yaml, read_yaml

__all__ = ["Document", "dump_yaml", "parse_yaml", "read", "read_yaml"]
