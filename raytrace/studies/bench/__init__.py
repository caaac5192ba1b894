"""Run time against error, and against work: what `raytrace bench` measures."""
