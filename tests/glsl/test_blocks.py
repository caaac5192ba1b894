import pytest

from raytrace.errors import InputError
from raytrace.glsl.blocks import without_blocks
from raytrace.glsl.source import ShaderSource


@pytest.mark.parametrize(
    ("code", "apart"),
    [
        ("uniform vec3 a;", "uniform vec3 a;"),
        ("uniform A { vec3 a; mat4 b; };", " uniform vec3 a; uniform mat4 b; "),
        ("layout(std140) uniform A{ layout(row_major) mat4 b; };", "uniform  mat4 b; "),
        ("uniform A{ vec3 a; } scene;", "struct A { vec3 a; }; uniform A  scene;"),
        ("float f(){ return 1.; }", "float f(){ return 1.; }"),
    ],
)
def test_a_block_is_its_uniforms(code, apart):
    assert without_blocks("a.frag", code).split() == apart.split()


@pytest.mark.parametrize(
    "code",
    [
        "layout(\nstd140\n) uniform\nA\n{\n vec3 a;\n\n mat4 b;\n}\n;\nint c;",
        "uniform A {\n\n vec3 a;\n} scene[2]\n;\nint c;",
        "\n\nuniform A { vec3 a; };\n\nuniform B {\nvec3 b; };\nint c;",
    ],
)
def test_lines_stay(code):
    apart = without_blocks("a.frag", code)
    assert "uniform" in apart
    assert apart.count("\n") == code.count("\n")
    assert apart.split("\n")[-1].strip() == code.split("\n")[-1].strip()


def test_a_storage_buffer_is_refused_by_name():
    with pytest.raises(InputError, match=r"^a\.frag:3: buffer Spheres: "):
        without_blocks("a.frag", "\n\nlayout(std430, binding = 0) readonly buffer Spheres { vec4 s[]; };")


def test_what_is_declared():
    text = "uniform float a, b[3]; uniform highp mat4 c; uniform Scene { vec3 d; }; uniform int e = 2; vec3 f;"
    assert ShaderSource("a.frag", text).declared == {"a": "", "b": "[3]", "c": "", "d": "", "e": "= 2"}
