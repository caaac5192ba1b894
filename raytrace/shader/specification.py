"""The version of what is computed."""

__all__ = ["SPECIFICATION", "VERSIONS"]

#: What each version of the specification changed. The specification says which number each pixel of a scene is in real
#: arithmetic (notebooks/specification.md); a better approximation of the same number is no new version.
VERSIONS = {
    1: "the assignment, with the choices that it leaves to the reader",
    2: "components that a white point makes negative become 0 before the tone mapper",
}

#: The version that this package computes. Golden images state the one that they were made by.
SPECIFICATION = max(VERSIONS)
