"""A module imports only from its own layer and those below; no modules import each other in a circle.

Every import is read, those inside functions too. The package's `__init__` stands above all.
"""

import ast
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from pathlib import Path

import raytrace

ROOT = Path(raytrace.__file__).parent

#: From the bottom up. The packages of one layer do not import each other.
LAYERS = [
    {"errors", "cores", "showing"},
    {"files", "tables", "colour_science"},
    {"language"},
    {"shader"},
    {"edges"},
    {"arithmetic"},
    {"scene"},
    {"image"},
    {"glsl"},
    {"backends"},
    {"rendering"},
    {"batches"},
    {"export"},
    {"comparison"},
    {"certificates"},
    {"mistakes"},
    {"inverse"},
    {"golden"},
    {"testing"},
    {"notebook"},
    {"studies"},
    {"cli"},
    {"__init__", "__main__"},
]


def modules(root):
    """Every module of the package at `root`, by name."""
    named = {}
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root.parent).with_suffix("").parts
        named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


def imported(source, names, top):
    """The modules among `names` that a module's source imports, of the package called `top`."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import"
            # Names that are no modules come from the package that is named first.
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            found = [name if name in names else node.module for name in inner]
        else:
            continue
        yield from (name for name in found if name and name.split(".")[0] == top)


def with_packages(module, others):
    """Those modules and the packages that they are in: Python runs a package's `__init__` before its modules.

    Packages that `module` itself is in, and the whole package, are left out: they have begun already.
    """
    for other in others:
        yield other
        parts = other.split(".")
        for end in range(2, len(parts)):
            if not f"{module}.".startswith(".".join(parts[:end]) + "."):
                yield ".".join(parts[:end])


def graph(root):
    """The modules that each module imports."""
    named = modules(root)
    return {
        name: set(with_packages(name, imported(path.read_text(), named, root.name))) for name, path in named.items()
    }


IMPORTS = graph(ROOT)


def package(module):
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def layer(module):
    (found,) = [i for i, names in enumerate(LAYERS) if package(module) in names]
    return found


def test_every_package_has_one_layer():
    packages = {package(module) for module in IMPORTS}
    named = [name for names in LAYERS for name in names]
    assert sorted(named) == sorted(packages)


def test_imports_run_downward():
    upward = {
        (module, other)
        for module, others in IMPORTS.items()
        for other in others
        if package(module) != package(other) and layer(other) >= layer(module)
    }
    assert upward == set()


def circle(imports):
    """The modules of one circle of imports, or an empty list."""
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_there_is_no_circle():
    assert circle(IMPORTS) == []


def test_the_reader_of_imports_sees_all_kinds(tmp_path):
    (tmp_path / "p" / "q").mkdir(parents=True)
    for path, source in {
        "p/__init__.py": "",
        "p/a.py": "import p.b\ndef f():\n    from p import c\n    from p.q import d, name\n",
        "p/b.py": "from p.a import f\nimport json\n",
        "p/c.py": "if True:\n    import p as other, p.b as b\n",
        "p/q/__init__.py": "name = 1\n",
        "p/q/d.py": "import os, p.q\n",
    }.items():
        (tmp_path / path).write_text(source)
    found = graph(tmp_path / "p")
    assert found["p.a"] == {"p.b", "p.c", "p.q.d", "p.q"}
    assert found["p.c"] == {"p", "p.b"}
    assert found["p.q.d"] == {"p.q"}
    loop = circle(found)
    assert set(pairwise(loop)) in ({("p.a", "p.b"), ("p.b", "p.a")}, {("p.a", "p.c"), ("p.c", "p.b"), ("p.b", "p.a")})


#: What writes to state that others share: a module's own variables, another object's inside, the environment, JAX's
#: caches. Where it is meant: Mitsuba reads where LLVM is from the environment.
SHARED_STATE = {("studies/bench/peers/llvm.py", "os.environ[]")}


def shared_state(source):
    """The kinds of statements in a module's source that change what others share."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Global):
            yield "global"
        elif isinstance(node, ast.Attribute) and node.attr in ("__dict__", "clear_caches"):
            yield node.attr
        elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store | ast.Del):
            yield from ["os.environ[]"] * (ast.unparse(node.value) == "os.environ")
        elif isinstance(node, ast.Call) and ast.unparse(node.func).startswith(("os.environ.", "os.putenv")):
            yield from ["os.environ"] * (ast.unparse(node.func) != "os.environ.get")


def test_state_is_explicit():
    found = {
        (path.relative_to(ROOT).as_posix(), kind)
        for path in ROOT.rglob("*.py")
        for kind in shared_state(path.read_text())
    }
    assert found == SHARED_STATE


def test_the_reader_of_state_sees_all_kinds():
    source = "import os, jax\ndef f(x):\n global y\n x.__dict__['a'] = 1\n os.environ['A'] = 'b'\n jax.clear_caches()"
    assert sorted(shared_state(source)) == ["__dict__", "clear_caches", "global", "os.environ[]"]
    assert list(shared_state("os.environ.setdefault('A', 'b')\nos.environ.get('A')\nos.environ['A']")) == ["os.environ"]
