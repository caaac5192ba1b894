"""``main()``: the assignment's steps, in its order."""

from raytrace.glsl.choices import Choices
from raytrace.glsl.functions import sphere_item
from raytrace.shader.main import COMPONENTS, Steps

__all__ = ["before_tone_mapping", "main_function", "step_function"]

_RAY = """\
vec3 ro = camPos;
vec2 pixelNdc = 2. * fragmentTextureCoordinates - 1.;
vec3 pixelViewSpace = (ndcToView * vec4(pixelNdc, 1., 1.)).xyz;
vec3 rd = normalize(mat3(viewToWorld) * pixelViewSpace);
"""
_PARALLEL_RAY = """\
// Extension: an orthographic camera's rays are parallel and start on the near plane.
vec2 pixelNdc = 2. * fragmentTextureCoordinates - 1.;
vec3 ro = (viewToWorld * (ndcToView * vec4(pixelNdc, -1., 1.))).xyz;
vec3 rd = normalize(-viewToWorld[2].xyz);
"""
_BACKGROUND = "col = backgroundColor(rd);\n"


def main_function(choices: Choices) -> str:
    """``main()``; of several samples a pixel, ``main()`` and the function that it calls for each."""
    if choices.samples == 1:
        return _function("void main()", _color(choices) + _written(choices))
    width, height = choices.size
    return (
        "// Departure: the mean of several samples a pixel, in linear light.\n"
        + _function("vec3 sampleColor(vec2 fragmentTextureCoordinates)", _color(choices) + "return col;\n")
        + "\n"
        + _function(
            "void main()",
            f"const int samples = {choices.samples};\n"
            f"const vec2 pixel = vec2(1. / {width}., 1. / {height}.);\n"
            "vec3 col = vec3(0);\n"
            "for(int i = 0; i < samples*samples; i++){\n"
            "    vec2 place = (vec2(i % samples, i / samples) + 0.5) / float(samples) - 0.5;\n"
            "    col += sampleColor(fragmentTextureCoordinates + place*pixel);\n"
            "}\n"
            "col /= float(samples*samples);\n" + _written(choices),
        )
    )


def step_function() -> str:
    """``stepColor``: the step that ``shownStep`` asks for, as the components of a colour."""
    cases = []
    for i, name in enumerate(Steps._fields):
        components = COMPONENTS[name]
        step = {"linear": "linear", "display": "display", "index": "float(steps.index)"}.get(name, f"steps.{name}")
        value = f"vec4({', '.join([step, *['0.'] * (3 - components), '1.'])})"
        cases.append(f"    if(shownStep == {i}) return {value}; // {name}\n")
    return "vec4 stepColor(vec3 linear, vec3 display){\n" + "".join(cases) + "    return vec4(0);\n}\n"


def _color(choices: Choices) -> str:
    """From ``fragmentTextureCoordinates`` to ``col``."""
    ray = _PARALLEL_RAY if choices.orthographic else _RAY
    kept = ""
    if choices.output == "steps":
        kept = "\nsteps = Steps(pixelNdc, rd, -1., -1, vec3(0), vec3(0), 0., 0., 0., vec3(0));\n"
    if not (choices.spheres or choices.planes):
        return f"{ray}{kept}\n// Departure: there is neither a sphere nor a plane.\nvec3 {_BACKGROUND}"
    search, branches = "", []
    if choices.spheres:
        search += "int sphereIndex;\nfloat t = closestSphereIntersect(ro, rd, sphereIndex);\n"
    else:
        search += "// Departure: there is no sphere.\n"
    if choices.planes:
        search += "int planeIndex;\nfloat tPlane = closestPlaneIntersect(ro, rd, planeIndex);\n"
        nearest = "(t > 0.0 ? t : infinity)" if choices.spheres else "infinity"
        branches.append((f"tPlane < {nearest}", _surface("tPlane", "planes[planeIndex].normal", choices, "plane")))
    if choices.spheres:
        normal = f"normalize(hitPoint-{sphere_item('sphereIndex', choices)}.center)"
        branches.append(("t > 0.0", _surface("t", normal, choices, "sphere")))
    chain = "else ".join(f"if({condition}){{\n{_indented(body)}}}\n" for condition, body in branches)
    return f"{ray}{kept}\nvec3 col = vec3(0);\n{search}{chain}else\n{_indented(_BACKGROUND)}"


def _surface(t: str, normal: str, choices: Choices, kind: str) -> str:
    """The colour of a surface that the ray meets at `t`."""
    if kind == "sphere":
        color, index = f"{sphere_item('sphereIndex', choices)}.color", "sphereIndex"
    else:
        index = f"{choices.spheres} + planeIndex" if choices.spheres else "planeIndex"
        color = "planes[planeIndex].color"
        if choices.patterned:
            color = "checkerboard(hitPoint, planes[planeIndex])"
        if choices.printed_checkerboard:
            color = "checkerboard(hitPoint, planes[planeIndex].tileSize)"
    lit, steps = choices.lighting != "off", choices.output == "steps"
    lines = []
    if lit or steps or (choices.patterned and kind == "plane"):
        lines.append(f"vec3 hitPoint = ro + {t}*rd;")
    if lit or steps:
        lines.append(f"vec3 normal = {normal};")
    if steps:
        lines += [f"vec3 albedo = {color};", f"steps.t = {t};", f"steps.index = {index};"]
        lines += ["steps.hitPoint = hitPoint;", "steps.N = normal;", "steps.albedo = albedo;"]
        color = "albedo"
    if lit:
        lines.append("vec3 light = lightAtPoint(hitPoint, normal);")
    lines.append(f"col = {'light*' if lit else ''}{color};")
    return "\n".join(lines) + "\n"


def before_tone_mapping(exposure: bool, white_balance: bool) -> str:
    """``col`` after exposure and white balance, where there are any (`raytrace.shader.film.develop`)."""
    developed = "exposureFactor * col" if exposure else "col"
    if not white_balance:
        return developed
    return f"max(whiteBalance * {f'({developed})' if exposure else developed}, 0.)"


def _written(choices: Choices) -> str:
    """From ``col`` to ``fragColor``."""
    if choices.output == "linear":
        return "fragColor = vec4(col, 1.); // Departure: linear light, before the film.\n"
    developed = before_tone_mapping(choices.exposure, choices.white_balance)
    note = "// Extension: exposure and white balance.\n" if developed != "col" else ""
    if choices.white_balance:
        note += "// Departure: white balance makes components of saturated colors negative; light is at least 0.\n"
    if choices.output == "steps":
        return f"{note}fragColor = stepColor(col, tonemapAndGammaCorrect({developed}));\n"
    return f"{note}fragColor = vec4(tonemapAndGammaCorrect({developed}), 1.);\n"


def _function(head: str, body: str) -> str:
    return f"{head}{{\n{_indented(body)}}}\n"


def _indented(text: str) -> str:
    return "".join(f"    {line}" if line.strip() else line for line in text.splitlines(keepends=True))
