"""The front doors from Python: what the package's top level offers."""
