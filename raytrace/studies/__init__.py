"""Measurements of raytrace itself. Nothing else in the package depends on them, but for the command."""
