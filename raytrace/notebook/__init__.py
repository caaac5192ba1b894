"""For Jupyter: pictures side by side, and exercises that are checked."""

from raytrace.notebook.exercise import Answer, check
from raytrace.notebook.pictures import Pictures, pictures, png

__all__ = ["Answer", "Pictures", "check", "pictures", "png"]
