#!/usr/bin/python3
"""Checks the modules of Trevi: who includes whom, which libraries show where, file lengths, top-level folders.

The rules (ARCHITECTURE.md): a module includes only itself and lower modules; no circular includes; a public header (those of
include/trevi, listed below with their module) includes public headers only; mpi.h and petsc*.h in headers of parallel/ and
domain/ only; HDF5 and VTK only in src/io, VTK in src/view, too, which alone may draw (X11, VTK's rendering); sndfile
only in src/music/*.cpp; ZeroMQ only in src/live and src/view; no file over 400 lines; no other folders at the top than
the known ones; folders of tests/ are those of the modules; the figure of the modules in ARCHITECTURE.md is that of the
code; no banned words.
Prints each violation as file:line: message and exits 1 when there is one.
"""

import argparse
import re
import sys
import tempfile
from collections import namedtuple
from pathlib import Path

MODULES = ["base", "parallel", "particles", "domain", "kernels", "boundary", "fluid", "multigrid", "projection",
           "music", "io", "solver", "live", "scene", "app", "view"]
PUBLIC = {  # header of the library: its module
    "types": "base", "box": "base", "clock": "base", "colour": "base", "error": "base",
    "session": "parallel", "requests": "parallel", "particles": "particles",
    "settings": "particles", "wavemaker": "particles", "obstacle": "particles", "body": "particles", "forcing": "particles", "observer": "particles", "solver": "solver", "scene": "scene",
}
FOLDERS = {"jobs", "inputs", "postprocess", "python", "tests", "src", "include"}
TEST_FOLDERS = {"support", "regression", "embed", "extending", "benchmarks"}  # besides those of the modules
MAX_LINES = 400
CODE = {".hpp", ".h", ".cpp"}
COUNTED = CODE | {".py", ".sh", ".cmake"}

MPI = re.compile(r"(mpi|petsc\w*)\.h$")
# What may include a library's headers, as a pattern over the path from the project's root.
LIBRARIES = {
    "HDF5": (re.compile(r"(hdf5|hdf5_hl|H5\w*)\.h$"), re.compile(r"src/io/")),
    "VTK": (re.compile(r"vtk\w*\.h$"), re.compile(r"src/io/|src/view/")),
    "sndfile": (re.compile(r"sndfile\.(h|hh)$"), re.compile(r"src/music/\w+\.cpp$")),
    "rendering": (re.compile(r"vtk\w*(Render|Actor|Camera|Mapper|Interactor)\w*\.h$|Xlib\.h$"),
                  re.compile(r"src/view/")),
    "ZeroMQ": (re.compile(r"zmq\.(h|hpp)$"), re.compile(r"src/(live|view)/\w+\.cpp$")),
}

Include = namedtuple("Include", "line name")


def read_includes(path):
    """Includes of a file in order, those in comments left out."""
    text = path.read_text(encoding="utf-8", errors="replace")
    text = re.sub(r"/\*.*?\*/", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.S)
    found = []
    for number, line in enumerate(text.splitlines(), start=1):
        match = re.match(r'\s*#\s*include\s*["<]([^">]+)[">]', line)
        if match:
            found.append(Include(number, match[1]))
    return found


def module_of(file):
    """Module of a path from the project's root ("src/fluid/x.cpp"), None when it is in none."""
    parts = file.split("/")
    if parts[:2] == ["include", "trevi"]:
        return PUBLIC.get(parts[2].removesuffix(".hpp")) if len(parts) == 3 else None
    return parts[1] if len(parts) > 2 and parts[1] in MODULES else None


class Tree:
    def __init__(self, root):
        self.root = root
        paths = (p for top in ("include", "src") for p in (root / top).rglob("*") if p.suffix in CODE)
        self.includes = {p.relative_to(root).as_posix(): read_includes(p) for p in sorted(paths)}

    def resolve(self, file, name):
        """Path from the root of what `file` includes by `name`; for a trevi/ header even if it does not exist (yet)."""
        if name.startswith("trevi/"):
            return "include/" + name
        for base in (Path(file).parent, Path("src")):
            path = (self.root / base / name).resolve()
            if path.is_file() and self.root in path.parents:
                return path.relative_to(self.root).as_posix()
        return None


def check_layers(tree):
    for file, includes in tree.includes.items():
        own = module_of(file)
        if own is None:
            yield file, 1, f"is in no module; they are {', '.join(MODULES)}"
            continue
        for line, name in includes:
            target = tree.resolve(file, name)
            if target is None:
                continue
            other = module_of(target)
            if other is None:
                yield file, line, f"{name} is in no module"
            elif MODULES.index(other) > MODULES.index(own):
                yield file, line, f"{own} includes {name}, which is in a higher module"
            elif file.startswith("include/") and target.startswith("src/"):
                yield file, line, f"the public header includes {name}, which is not public"


def check_public(tree):
    """What solver.hpp and scene.hpp, the doors of the library, do not lead to only the library itself would include."""
    reached, todo = set(), ["include/trevi/solver.hpp", "include/trevi/scene.hpp"]
    while todo:
        file = todo.pop()
        if file in reached or file not in tree.includes:
            continue
        reached.add(file)
        todo += [tree.resolve(file, include.name) for include in tree.includes[file]]
    for file in tree.includes:
        if file.startswith("include/") and module_of(file) and file not in reached:
            yield file, 1, "no program that uses the library needs it; keep it beside its source"


def module_graph(tree):
    """The figure of ARCHITECTURE.md: an arrow from each module to those that it includes, but for those that it reaches
    by another arrow anyway."""
    used = {module: set() for module in MODULES}
    for file, includes in tree.includes.items():
        if file.startswith("src/") and module_of(file):
            targets = (tree.resolve(file, include.name) for include in includes)
            used[module_of(file)] |= {module_of(t) for t in targets if t and t.startswith("src/")} - {module_of(file), None}
    reached = {}
    for module in MODULES:  # those below come first
        reached[module] = used[module].union(*(reached[other] for other in used[module]))
    lines = ["flowchart TD"]
    for module in reversed(MODULES):
        direct = [o for o in MODULES if o in used[module] and not any(o in reached[p] for p in used[module])]
        lines += [f"  {module} --> {other}" for other in direct]
    return lines


def check_figure(tree, root):
    page = root / "ARCHITECTURE.md"
    if page.exists():
        match = re.search(r"```mermaid\n(flowchart TD\n.*?)```", page.read_text(), re.S)
        if match is None or match[1].splitlines() != module_graph(tree):
            yield "ARCHITECTURE.md", 1, "the figure of the modules is not that of the code; see tests/layering.py --figure"


BANNED = re.compile(r"\b(Toll|SolidMap|PlaneLike|WaterReach|CoarseSolids|Ballot|MomentumKeeper|last_plane\w*|\w*crowded|"
                    r"seam|tell_\w+|\w*vote[sd]?(?:_\w+)?|Vote|leave_water|start_at_rest|most_\w+|least_(?!squares)\w+)\b")
BANNED_IN_PAGES = re.compile(r"\b(house rules?|[Rr]ooms (?:only|look)|books|vote[sd]?|hair)\b")


def check_words(root):
    """Words of former versions that nobody else uses; the glossary of ARCHITECTURE.md has the field's."""
    for folder in ("include", "src", "tests", "python", "postprocess", "inputs", "jobs", "."):
        paths = root.glob("*.md") if folder == "." else (root / folder).rglob("*")
        for path in sorted(paths):
            banned = BANNED_IN_PAGES if path.suffix == ".md" else BANNED if path.suffix in CODE | {".py"} else None
            if banned is None or path.name in (Path(__file__).name, "CHANGELOG.md"):
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
                for word in banned.findall(line):
                    yield (path.relative_to(root).as_posix(), number,
                           f"\"{word}\" is not a word of the field; see the glossary of ARCHITECTURE.md")


def check_tests(root):
    """Folders of tests are those of the modules, and a few of their own."""
    for path in sorted((root / "tests").glob("*/")) if (root / "tests").is_dir() else []:
        if path.is_dir() and path.name not in {*MODULES, *TEST_FOLDERS, "__pycache__"}:
            yield path.relative_to(root).as_posix(), 1, "is neither a module nor one of " + ", ".join(sorted(TEST_FOLDERS))


def check_libraries(tree):
    for file, includes in tree.includes.items():
        for line, name in includes:
            base = name.split("/")[-1]
            if file.endswith(".hpp") and MPI.match(base) and module_of(file) not in ("parallel", "domain"):
                yield file, line, f"{name} in a header outside parallel/ and domain/"
            for library, (header, allowed) in LIBRARIES.items():
                if header.match(base) and not allowed.match(file):
                    yield file, line, f"{library} ({name}) may not show here"


def check_circles(tree):
    done = set()

    def visit(file, chain):
        if file in chain:
            circle = chain[chain.index(file):]
            line = next(i.line for i in tree.includes[circle[-1]] if tree.resolve(circle[-1], i.name) == file)
            yield circle[-1], line, "circular include: " + " -> ".join([*circle, file])
            return
        if file in done or file not in tree.includes:
            return
        for include in tree.includes[file]:
            target = tree.resolve(file, include.name)
            if target is not None:
                yield from visit(target, [*chain, file])
        done.add(file)

    for file in tree.includes:
        yield from visit(file, [])


def check_lengths(root):
    for folder in sorted(FOLDERS - {"inputs"}):
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and (path.suffix in COUNTED or path.name == "CMakeLists.txt"):
                lines = len(path.read_text(encoding="utf-8", errors="replace").splitlines())
                if lines > MAX_LINES:
                    yield path.relative_to(root).as_posix(), MAX_LINES + 1, f"{lines} lines; at most {MAX_LINES}"


def check_folders(root):
    ignore = root / ".gitignore"
    ignored = {line.strip().strip("/") for line in ignore.read_text().splitlines()} if ignore.exists() else set()
    for path in sorted(root.iterdir()):
        if path.is_dir() and not path.name.startswith(".") and path.name not in FOLDERS | ignored:
            yield path.name, 1, f"unknown folder at the top; known are {', '.join(sorted(FOLDERS))}"


def violations(root):
    root = root.resolve()
    tree = Tree(root)
    checks = (check_layers(tree), check_public(tree), check_libraries(tree), check_circles(tree), check_lengths(root),
              check_folders(root), check_figure(tree, root), check_words(root), check_tests(root))
    return [violation for check in checks for violation in check]


# Self-test: a tree with one violation of each kind, and neighbours of each that are allowed.
GOOD = {
    "include/trevi/types.hpp": "#pragma once\n#include <vector>\n",
    "include/trevi/session.hpp": '#include <mpi.h>\n#include "trevi/types.hpp"\n',
    "include/trevi/solver.hpp": '#include "trevi/session.hpp"\n#include "trevi/types.hpp"\n',
    "include/trevi/scene.hpp": "".join(f'#include "trevi/{name}.hpp"\n' for name in ("box", "forcing", "particles")),
    "src/base/bits.hpp": "\n",
    "src/domain/halo.hpp": "#include <petscvec.h>\n",
    "src/fluid/kernel.hpp": '// #include "trevi/scene.hpp"\n/*\n#include <hdf5.h>\n*/\n#include "trevi/types.hpp"\n',
    "src/music/music.cpp": '#include <sndfile.h>\n#include "table.hpp"\n',
    "src/music/table.hpp": '#include "fluid/kernel.hpp"\n',
    "src/io/frames/vtu.cpp": "#include <vtkPoints.h>\n#include <hdf5.h>\n",
    "src/solver/step.cpp": '#include <mpi.h>\n#include "fluid/kernel.hpp"\n',
    "src/live/link.cpp": "#include <zmq.hpp>\n",
    "src/view/window.cpp": "#include <vtkRenderer.h>\n#include <zmq.hpp>\n",
    "src/app/main.cpp": '#include "trevi/scene.hpp"\n',
    "jobs/run.sh": "\n" * MAX_LINES, "tests/fluid/test_x.cpp": "\n", "tests/support/x.hpp": "\n",
    ".gitignore": "build/\n/out\n",
    "build/x": "", "out/x": "", ".ci/run": "",
}
BAD = [  # file, text, the line and a word of the violation
    ("include/trevi/box.hpp", '#pragma once\n#include "trevi/settings.hpp"\n', 2, "higher module"),
    ("include/trevi/forcing.hpp", '#include "base/bits.hpp"\n', 1, "not public"),
    ("include/trevi/extra.hpp", "\n", 1, "in no module"),
    ("include/trevi/particles.hpp", "#include <mpi.h>\n", 1, "mpi.h"),
    ("include/trevi/observer.hpp", "\n", 1, "no program"),
    ("src/fluid/up.cpp", '#include "../solver/private.hpp"\n', 1, "higher module"),
    ("src/solver/odd.cpp", '\n\n  #  include "trevi/extras/odd.hpp"\n', 3, "in no module"),
    ("src/stray.cpp", "\n", 1, "in no module"),
    ("src/fluid/mpi.hpp", "#include <mpi.h>\n", 1, "mpi.h"),
    ("src/solver/petsc.hpp", "#include <petscvec.h>\n", 1, "petscvec.h"),
    ("src/app/hdf.hpp", "#include <hdf5.h>\n", 1, "HDF5"),
    ("src/app/build.cpp", "#include <vtkPoints.h>\n", 1, "VTK"),
    ("src/music/sound.hpp", "#include <sndfile.h>\n", 1, "sndfile"),
    ("src/io/draw.cpp", "#include <vtkRenderer.h>\n", 1, "rendering"),
    ("src/app/line.cpp", "#include <zmq.hpp>\n", 1, "ZeroMQ"),
    ("src/app/peep.cpp", '#include "../view/peephole.hpp"\n', 1, "higher module"),
    ("src/domain/b.hpp", '#include "domain/a.hpp"\n', 1, "circular"),
    ("src/fluid/long.cpp", "\n" * (MAX_LINES + 1), MAX_LINES + 1, "401 lines"),
    ("src/fluid/words.hpp", "class Toll;\n", 1, "not a word"),
    ("inputs/page.md", "The house rules.\n", 1, "not a word"),
    ("tests/unit/test_all.cpp", "\n", 1, "neither a module"),
    ("docs/manual.txt", "", 1, "unknown folder"),
]
BAD_HELPERS = {"src/solver/private.hpp": "\n", "src/view/peephole.hpp": "\n", "include/trevi/settings.hpp": "\n",
               "src/domain/a.hpp": '#include "domain/b.hpp"\n'}


def write_tree(root, files):
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        write_tree(root, GOOD)
        failures = [f"false alarm: {v}" for v in violations(root)]
        write_tree(root, BAD_HELPERS | {file: text for file, text, *_ in BAD})
        found = violations(root)
    for file, _, line, word in BAD:
        reported = {"unknown folder": "docs", "neither a module": "tests/unit"}.get(word, file)
        if not any((v[0], v[1]) == (reported, line) and word in v[2] for v in found):
            failures.append(f"not found: {file}:{line}: {word}")
    if len(found) != len(BAD):
        failures.append(f"planted {len(BAD)} violations, found {len(found)}: {found}")
    return failures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parent.parent,
                        help="project (default: this one)")
    parser.add_argument("--self-test", action="store_true", help="plant violations in a temporary tree and find them")
    parser.add_argument("--figure", action="store_true", help="print the figure of the modules for ARCHITECTURE.md")
    arguments = parser.parse_args()
    if arguments.figure:
        print("\n".join(module_graph(Tree(arguments.root.resolve()))))
        return 0
    if arguments.self_test:
        failures = self_test()
        print("\n".join(failures) or f"{len(BAD)} planted violations found, no false alarm")
        return 1 if failures else 0
    if not (arguments.root / "src").is_dir():
        parser.error(f"no src/ in {arguments.root}")
    found = violations(arguments.root)
    for file, line, message in found:
        print(f"{file}:{line}: {message}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
