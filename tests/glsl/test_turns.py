"""The text that is put into a shader to see whether its loops were cut; that it does is tested with the engine."""

from raytrace.glsl.turns import counted, loops, watched

CODE = """\
#version 300 es
#extension GL_OES_standard_derivatives : enable
int f(int n){ for(int i = 0; i < n; i++) for(;;) break; return n; }
void main ( )
{
    do { f(3); } while((1 > 2));
    while (f(2) < (3)) f(1);
}
"""


def test_loops_and_their_conditions():
    found = [(loop.line, CODE[loop.begin : loop.end].strip()) for loop in loops(CODE)]
    assert found == [(3, "i < n"), (3, ""), (6, "(1 > 2)"), (7, "f(2) < (3)")]


def test_what_is_no_loop():
    assert loops("int forward(int a); int whiley; for(a; b) for(") == []


def test_every_loop_counts():
    text = counted(CODE)
    assert [f"raytraceTurn({i}) && " in text for i in range(5)] == [True] * 4 + [False]
    assert "raytraceTurn(1) && gl_FragCoord.x > -1. && (true)" in text
    assert text.index("raytraceTurnsOf[4]") > text.index("#extension")


def test_main_is_called():
    for text in (watched(CODE), counted(CODE)):
        assert "void raytraceMain( )" in text
        assert text.count("void main(){") == 1


def test_a_shader_without_main_is_left_alone():
    assert watched("void f(){}") is counted("void f(){}") is None
