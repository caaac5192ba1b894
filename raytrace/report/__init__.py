"""What the shader is given and what it does at a pixel, for somebody who debugs another renderer."""

from raytrace.report.pixel import pixel_report
from raytrace.report.uniforms import uniforms_report

__all__ = ["pixel_report", "uniforms_report"]
