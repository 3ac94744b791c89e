"""The diagnosis of measured levels, transmission loss and absorption: data, laws of parallel paths, hypothesis."""
