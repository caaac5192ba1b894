"""What the shader is written in: GLSL's vocabulary over planes, words of control flow, and the engines that run them.

A plane is an array of one number a pixel, of any array library with ``__array_namespace__``. A jet is a plane that
knows how it changes from one pixel to the next. `raytrace.language.glsl` has the vocabulary,
`raytrace.language.control` the words, and `raytrace.language.engine` what they become.
"""
