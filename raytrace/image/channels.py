"""Which of a file's channels are its picture: the one layer of red, green and blue, or the one that is named."""

from collections.abc import Iterable

from raytrace.errors import InputError

__all__ = ["UNNAMED", "picture_channels"]

#: The layer of channels that have no layer's name, which is what a viewer shows.
UNNAMED = ""

_COLORS = {"r": "red", "red": "red", "g": "green", "green": "green", "b": "blue", "blue": "blue"}
_ALPHA = ("a", "alpha")
_GREY = ("y", "i", "l", "grey", "gray", "luminance")


def picture_channels(path: object, names: Iterable[str], layer: str | None = None) -> tuple[str, ...]:
    """Return the names of the channels of red, green and blue, or the name of the one channel of grey.

    A name is that of a layer and of a channel, as in ``beauty.R``. names: of all channels. layer: which layer is meant,
    for a file with several; a file without layers ignores it.

    Raises:
        InputError: there is no such layer, several that could be meant, or none that is a picture. `path` begins the
            message, which names the layers and the channels.
    """
    names = list(names)
    layers = _layers(names)
    if layer is not None and layer in layers:
        return layers[layer]
    if layer is not None and set(layers) != {UNNAMED}:
        raise InputError(f"{path}: has no layer {layer!r} of red, green and blue; {_found(layers, names)}")
    if UNNAMED in layers:
        return layers[UNNAMED]
    if len(layers) == 1:
        return next(iter(layers.values()))
    if layers:
        raise InputError(
            f"{path}: has several layers of red, green and blue; name one (--layer); {_found(layers, names)}"
        )
    grey = [name for name in names if _channel(name)[1] not in _ALPHA]
    if len(grey) == 1 and (len(names) == 1 or _channel(grey[0])[1] in _GREY):
        return (grey[0],)
    raise InputError(f"{path}: has no red, green and blue; {_found(layers, names)}")


def _channel(name: str) -> tuple[str, str]:
    """The layer and the channel of a name."""
    layer, _, channel = name.rpartition(".")
    return layer, channel.lower()


def _layers(names: list[str]) -> dict[str, tuple[str, ...]]:
    """The red, green and blue of each layer that has all three."""
    found: dict[str, dict[str, str]] = {}
    for name in names:
        layer, channel = _channel(name)
        if channel in _COLORS:
            found.setdefault(layer, {}).setdefault(_COLORS[channel], name)
    colors = ("red", "green", "blue")
    return {layer: tuple(of[color] for color in colors) for layer, of in found.items() if len(of) == len(colors)}


def _found(layers: dict[str, tuple[str, ...]], names: list[str]) -> str:
    told = f"its layers are {', '.join(layers)}" if layers else f"its channels are {', '.join(names)}"
    return told if len(told) <= MOST_TOLD else f"{told[:MOST_TOLD]} ..."


#: Letters of a message that are spent on names.
MOST_TOLD = 160
