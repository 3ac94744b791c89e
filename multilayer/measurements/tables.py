"""Tables of measured values, as `multilayer.tables` reads them."""

from multilayer.tables import Header, Table, name_and_unit, other_width, read_text_table

__all__ = ["Header", "Table", "name_and_unit", "other_width", "read_text_table"]
