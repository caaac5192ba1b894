"""How far the compiled program is from what the machine can do."""

from typing import Any, NamedTuple

import numpy as np

from raytrace.rendering import Options, Rendering
from raytrace.scene.data import Scene
from raytrace.studies.bench.timing import in_turn

__all__ = ["Roofline", "roofline"]


class Roofline(NamedTuple):
    """Floating point operations and bytes of one frame as XLA counts them, and this machine's measured peaks.

    XLA counts a loop's body once and each side of a branch, whether it runs or not, so the counts are those of one tile
    times the number of tiles: what is skipped is counted. `at_least` is the time that the operations would take
    at the peak rate of fused multiply-adds, `share` that over the measured time.
    """

    operations: float
    bytes: float
    peak_operations: float
    peak_bytes: float
    milliseconds: float
    at_least: float
    share: float


def roofline(scene: Scene | str, size: tuple[int, int], runs: int) -> Roofline:
    """Of the scene in JAX float32, without skipping: then what is counted is what is computed."""
    rendering = Rendering(Options(scene, size, skip=False))
    cost, tiles = cost_of_a_tile(rendering)
    operations, moved = tiles * cost.get("flops", 0.0), tiles * cost.get("bytes accessed", 0.0)
    fused, copied = _peaks()
    timings = in_turn({"frame": rendering.whole, "fused": fused[0], "copied": copied[0]}, runs)
    peak_operations = fused[1] / (1e-3 * timings["fused"].fastest)
    peak_bytes = copied[1] / (1e-3 * timings["copied"].fastest)
    milliseconds = timings["frame"].median
    at_least = 1e3 * operations / peak_operations
    return Roofline(operations, moved, peak_operations, peak_bytes, milliseconds, at_least, at_least / milliseconds)


def cost_of_a_tile(rendering: Rendering) -> tuple[dict[str, float], int]:
    """Return XLA's count of the operations and bytes of one tile of JAX's, and how many tiles all devices draw."""
    from raytrace.backends.jax.draw import tiles_of

    renderer: Any = rendering.renderer
    width, height, _ = rendering.frame
    devices = renderer.devices.size
    tiles = tiles_of(renderer.engine, renderer.job, height, -(-width // devices))
    return renderer.executable(height).cost_analysis(), tiles.down * tiles.across * devices


def _peaks() -> tuple:
    """A loop of fused multiply-adds and a copy, on all devices: functions, and their operations and bytes."""
    import jax
    import jax.numpy as jnp
    from jax import lax
    from jax.sharding import NamedSharding, PartitionSpec

    from raytrace.backends.jax.devices import AXIS, mesh
    from raytrace.backends.jax.renderer import OPTIONS

    devices = mesh()
    chains, depth, width, turns = 8, 32, 4096, 2000

    def multiply_add(x: jax.Array) -> jax.Array:
        # One kernel, of numbers that stay in the cache, with so many chains that do not wait for each other.
        def turn(_: Any, x: jax.Array) -> jax.Array:
            each = [x + k for k in range(chains)]
            for _ in range(depth):
                each = [one * jnp.float32(0.999) + jnp.float32(0.001) for one in each]
            return sum(each[1:], each[0]) / chains

        return lax.fori_loop(0, turns, turn, x)

    def on_all(function: Any, x: Any) -> Any:
        spread = jax.device_put(x, NamedSharding(devices, PartitionSpec(AXIS)))
        run = jax.jit(
            jax.shard_map(
                lambda x: function(x[0])[None],
                mesh=devices,
                in_specs=PartitionSpec(AXIS),
                out_specs=PartitionSpec(AXIS),
                check_vma=False,
            ),
            compiler_options=OPTIONS,
        )
        return lambda: run(spread)

    n = devices.size
    large = np.ones((n, 1 << 23), np.float32)
    fused = on_all(multiply_add, np.ones((n, width), np.float32))
    copied = on_all(lambda x: x + 1, large)
    return (fused, 2.0 * depth * turns * chains * width * n), (copied, 2.0 * large.nbytes)
