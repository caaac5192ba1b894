"""The assignment's GLSL on graphics engines, each in a process of its own."""
