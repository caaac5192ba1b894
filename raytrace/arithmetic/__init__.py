"""Arithmetics of our own, on which the shader's text runs as it is: exact numbers, and intervals."""
