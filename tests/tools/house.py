#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the rules of the house: includes between rooms, circles of calls, tags,
private headers, sizes, licences, globals, inexact functions,
subjects of commits.

Usage: house.py ROOT BUILD     BUILD must have its objects

Prints a line for each broken rule, and exits 1 if there is one.
"""
import os
import re
import subprocess
import sys

ROOT, BUILD = sys.argv[1], sys.argv[2]
SRC = os.path.join(ROOT, "src")

# A room may include its own headers, those of the rooms named here, and the
# single headers named here.
INSIDE = ["glare", "sun", "scene", "tone", "compare", "gl", "core"]
ROOMS = {
    "core": [],
    "gl": ["core"],
    "glare": ["gl", "core"],
    "sun": ["gl", "core", "glare/kernel.h", "glare/sources.h"],
    "scene": ["gl", "core"],
    "tone": ["gl", "core"],
    "io": ["gl", "core"],
    "compare": ["core"],
    "api": INSIDE,
    # the program sees the library as any other caller, by <glarepp.h>
    "bench": ["io", "core"],
    "cli": ["bench", "io", "core"],
}
# Only one room may include a library's headers.
LIBRARIES = [
    (r"openexr|Imf|OpenEXR|OpenImageIO|png|libdeflate", "io"),
    (r"OpenColorIO", "tone"),
    (r"GL/|EGL/", "gl"),
]
# Files of an unusual size, and why.
SHORT, LONG = 80, 700
SIZES = {  # path below src: reason
    "core/half.c": "halves; numbers of 16 bits, there and back",
    "core/image.c": "planes; what a picture is stands in its header",
    "glare/fft/double.c": "the transform and its passes once more, in double",
    "glare/model/aperture.c": "openings of a lens and of an eye, drawn alike",
}
# Rooms that measure, whose figures may differ between processors: the others make
# light, and take elementary functions from core/maths.h.
MEASURING = ("bench/", "compare/")
INEXACT = re.compile(
    r"(sincos|a?(sin|cos|tan)h?|atan2|exp(2|10|m1)?|log(2|10|1p)?|pow|hypot|cbrt|"
    r"erfc?|[jy][01n]|[lt]gamma|fma|c(abs|arg|exp|log|pow|sqrt))[fl]?")
LICENCE = "SPDX-License-Identifier: Apache-2.0"
COMMENTED = (".c", ".h", ".cpp", ".inc", ".glsl", ".frag", ".vert", ".py", ".sh", ".t",
             ".awk", ".yaml")
SUBJECT = re.compile(
    r"^[a-z][a-z0-9_-]*(/[a-z0-9_-]+)*(, [a-z0-9_/-]+)*: \S.*[^.]$")
SINCE = "8c81615"  # later commits must have subjects of this form

broken = 0


def fault(rule, text):
    global broken
    broken += 1
    print(f"{rule}: {text}")


def sources():
    for folder, _, names in sorted(os.walk(SRC)):
        for name in sorted(names):
            if name.endswith((".c", ".h", ".cpp", ".hpp")):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as f:
                    yield os.path.relpath(path, SRC), f.read()


def check_includes(files):
    for path, text in files.items():
        room = path.split("/")[0]
        for angle, name in re.findall(r'^ *# *include *([<"])([^>"]+)', text,
                                      re.M):
            if angle == "<":
                for library, owner in LIBRARIES:
                    if re.match(library, name) and room != owner:
                        fault("rooms", f"{path} includes <{name}>; only "
                                       f"{owner} may")
                continue
            other = name.split("/")[0]
            if other != room and other in ROOMS and \
                    other not in ROOMS[room] and name not in ROOMS[room]:
                fault("rooms", f"{path} includes {name}; {room} may include "
                               f"{', '.join(ROOMS[room]) or 'no other room'}")
            if name.endswith("_priv.h") and \
                    os.path.dirname(name) != os.path.dirname(path):
                fault("private", f"{path} includes {name} of another folder")


def check_words(files):
    """Messages of the library name no option: who calls it has others."""
    for path, text in files.items():
        joined = re.sub(r'"[\s\\]*"', "", text)
        if path.split("/")[0] in ["api"] + INSIDE:
            for line in re.findall(r'"[^"\n]*--[a-zA-Z][^"\n]*', joined):
                fault("words", f"{path} names an option: {line}")


def check_tags(files):
    where = {}
    for path, text in files.items():
        if path.endswith((".h", ".hpp")):
            for tag in re.findall(r"^(?:struct|union|enum) (\w+) \{", text,
                                  re.M):
                where.setdefault(tag, []).append(path)
    for tag, paths in where.items():
        if len(paths) > 1:
            fault("tags", f"{tag} is defined in {' and '.join(paths)}")


def check_sizes(files):
    for path, text in files.items():
        lines = text.count("\n")
        if path.endswith(".c") and not SHORT <= lines <= LONG and \
                path not in SIZES:
            fault("sizes", f"{path} has {lines} lines, not {SHORT} to {LONG}; "
                           "join or divide by idea, or give a reason in "
                           "tests/tools/house.py")
    for path in SIZES:
        if path not in files:
            fault("sizes", f"tests/tools/house.py excuses {path}, which does "
                           "not exist")
    for folder, _, names in os.walk(os.path.join(ROOT, "tests")):
        for name in names:
            if name.endswith((".c", ".h", ".cpp")):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as f:
                    lines = f.read().count("\n")
                if lines > LONG:
                    fault("sizes", f"{path} has {lines} lines, over {LONG}")
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as f:
        lines = f.read().count("\n")
    if lines > 150:
        fault("readme", f"README.md has {lines} lines, not at most 150")


def check_licences():
    """The first line of each source, after one of #!, names its licence."""
    for top in ("src", "tests", "examples", "man", ".ci"):
        for folder, _, names in sorted(os.walk(os.path.join(ROOT, top))):
            for name in sorted(names):
                if not name.endswith(COMMENTED) and name != "Makefile":
                    continue
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8", errors="replace") as f:
                    lines = [f.readline() for _ in range(2)]
                line = lines[lines[0].startswith("#!")]
                if line not in (f"// {LICENCE}\n", f"# {LICENCE}\n"):
                    fault("licences", f"{os.path.relpath(path, ROOT)} does not begin "
                                      f"with {LICENCE}")


def symbols(files):
    """For each .c: the gp_ symbols that it defines, and all that it uses."""
    defined, taken = {}, {}
    for path in files:
        if not path.endswith(".c"):
            continue
        out = subprocess.run(
            ["nm", "-g", os.path.join(BUILD, path[:-2] + ".o")],
            check=True, capture_output=True, text=True).stdout
        defined[path], taken[path] = set(), set()
        for line in out.splitlines():
            *_, kind, name = line.split()
            name = name.split(".")[0]
            if kind == "U":
                taken[path].add(name)
            elif name.startswith("gp_"):
                defined[path].add(name)
    return defined, taken


def check_circles(defined, taken):
    home = {name: path for path, names in defined.items() for name in names}
    arrows = {path: {home[n] for n in names if n in home} - {path}
              for path, names in taken.items()}
    number, low, stack, circles = {}, {}, [], []

    def visit(path):  # Tarjan 1972
        number[path] = low[path] = len(number)
        stack.append(path)
        for other in sorted(arrows[path]):
            if other not in number:
                visit(other)
                low[path] = min(low[path], low[other])
            elif other in stack:
                low[path] = min(low[path], number[other])
        if low[path] == number[path]:
            circle = [stack.pop()]
            while circle[-1] != path:
                circle.append(stack.pop())
            if len(circle) > 1:
                circles.append(sorted(circle))

    for path in sorted(arrows):
        if path not in number:
            visit(path)
    for circle in circles:
        inside = [f"{a} calls {b} ({', '.join(sorted(taken[a] & defined[b]))})"
                  for a in circle for b in circle if b in arrows[a]]
        fault("circles", "; ".join(inside))


def check_globals(files, defined, taken):
    used = set().union(*taken.values())
    private = "".join(text for path, text in files.items()
                      if path.endswith("_priv.h"))
    for path, names in defined.items():
        for name in sorted(names - used):
            if not re.search(rf"\b{name}\b", private):
                fault("globals", f"{name} of {path} is used by no other file; "
                                 "make it static")


def check_maths(taken):
    for path, names in taken.items():
        for name in sorted(names):
            if not path.startswith(MEASURING) and INEXACT.fullmatch(name):
                fault("maths", f"{path} calls {name}(), whose bits depend on "
                               "the processor; take core/maths.h")


def check_subjects():
    log = subprocess.run(["git", "-C", ROOT, "log", "--format=%s",
                          f"{SINCE}..HEAD"], capture_output=True, text=True)
    if log.returncode:
        print(f"subjects: not checked, {SINCE} is not in this clone")
        return
    for subject in log.stdout.splitlines():
        if not SUBJECT.match(subject):
            fault("subjects", f"'{subject}' is not 'room: what changed'")


def main():
    files = dict(sources())
    check_includes(files)
    check_words(files)
    check_tags(files)
    check_sizes(files)
    check_licences()
    defined, taken = symbols(files)
    check_circles(defined, taken)
    check_globals(files, defined, taken)
    check_maths(taken)
    check_subjects()
    return broken > 0


sys.exit(main())
