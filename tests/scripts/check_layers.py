#!/usr/bin/python3
"""The layer rule: which folder may include which, one library per folder, one type per name, heavy headers in .cpp files only, file length.

usage: check_layers.py [SOURCE_DIR]      exit 0 nothing found, 1 violations (one `file:line: rule` each)
"""

import os
import re
import sys

# docs/architecture.md, "Folders: who may include whom".
MAY_INCLUDE = {
    "base": set(),
    "firmware_iface": {"base"},
    "acquisition": {"base", "firmware_iface"},
    "fitting": {"base"},
    "modeling": {"base", "fitting"},
    "render": {"base", "modeling"},
    "sim": {"base", "firmware_iface", "modeling"},
    "station": {"base", "firmware_iface", "acquisition", "fitting", "modeling", "render", "sim"},
}
# Dear to compile, or C handles that one adapter owns: never in a header.
CPP_ONLY = re.compile(r"(ceres/|embree3/|webp/|opencv2/|boost/|openssl/|libusb|usbredir|modbus|gpiod|sqlite3\.h|.*\.hxx$)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
TYPE_DEFINITION = re.compile(r"^(?:struct|class|enum class) ([A-Za-z0-9_]+)(?: final)?(?: : .*| \{.*)$")
LIBRARY_CALL = re.compile(r"^\s*(annulus_library|add_library)\s*\(\s*(\S+)([^)]*)\)", re.MULTILINE)
MAX_LINES = 800
SOURCE_SUFFIXES = (".h", ".cpp", ".py", ".ts", ".sh", ".cmake")
SKIPPED_FOLDERS = {"node_modules", "dist", "corpus", "golden", "__pycache__"}


def files_under(folder):
    for path, folders, names in os.walk(folder):
        folders[:] = sorted(f for f in folders if f not in SKIPPED_FOLDERS)
        for name in sorted(names):
            yield os.path.join(path, name)


def check_includes(path, folder, lines):
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        kind, target = match.groups()
        if path.endswith(".h") and CPP_ONLY.match(target):
            yield number, f"<{target}> belongs in .cpp files only"
        if kind != '"':
            continue
        other = target.split("/")[0]
        if "/" not in target or other not in MAY_INCLUDE:
            yield number, f'"{target}": own headers are included by their path from the root'
        elif other != folder and other not in MAY_INCLUDE[folder]:
            allowed = ", ".join(sorted(MAY_INCLUDE[folder])) or "nothing"
            yield number, f"{folder} may not include {other} (it may include {allowed})"


def check_type_names(root):
    """One name, one type: two headers that define the same name would give the program two destructors of one name."""
    seen = {}
    for folder in MAY_INCLUDE:
        for path in files_under(os.path.join(root, folder)):
            if not path.endswith(".h"):
                continue
            with open(path, encoding="utf-8") as f:
                namespace = ""
                for number, line in enumerate(f, 1):
                    if line.startswith("namespace "):
                        namespace = line.split()[1]
                    match = TYPE_DEFINITION.match(line.rstrip())
                    if not match:
                        continue
                    name = f"{namespace}::{match.group(1)}"
                    if name in seen:
                        yield path, number, f"{name} is also defined in {os.path.relpath(seen[name], root)}"
                    seen.setdefault(name, path)


def check_libraries(root, folder):
    """Exactly one library per folder, named after it, linked only with folders that it may include."""
    seen = []
    for path in files_under(os.path.join(root, folder)):
        if os.path.basename(path) != "CMakeLists.txt":
            continue
        with open(path, encoding="utf-8") as f:
            text = re.sub(r"#.*", "", f.read())
        for call in LIBRARY_CALL.finditer(text):
            number = text.count("\n", 0, call.start(1)) + 1
            seen.append(call.group(2))
            if call.group(1) != "annulus_library" or call.group(2) != folder:
                yield path, number, f"a folder's one library is annulus_library({folder} …)"
            for word in call.group(3).split():
                if word in MAY_INCLUDE and word != folder and word not in MAY_INCLUDE[folder]:
                    yield path, number, f"{folder} may not link {word}"
    if len(seen) != 1:
        yield os.path.join(root, folder, "CMakeLists.txt"), 1, f"{len(seen)} libraries in {folder}, one expected"


def violations(root):
    """All (path, line, rule) of the tree at `root`."""
    for folder in MAY_INCLUDE:
        if not os.path.isdir(os.path.join(root, folder)):
            yield os.path.join(root, folder), 1, "this folder is missing"
            continue
        yield from check_libraries(root, folder)
    yield from check_type_names(root)
    for folder in [*MAY_INCLUDE, "tests", "cmake"]:
        for path in files_under(os.path.join(root, folder)):
            if not path.endswith(SOURCE_SUFFIXES):
                continue
            with open(path, encoding="utf-8") as f:
                lines = f.read().splitlines()
            if len(lines) > MAX_LINES:
                yield path, len(lines), f"{len(lines)} lines, at most {MAX_LINES}"
            if folder in MAY_INCLUDE and path.endswith((".h", ".cpp")):
                for number, rule in check_includes(path, folder, lines):
                    yield path, number, rule


def main(arguments):
    root = arguments[1] if len(arguments) > 1 else "."
    found = 0
    for path, line, rule in violations(root):
        print(f"{os.path.relpath(path, root)}:{line}: {rule}")
        found += 1
    print(f"layers: {found} violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
