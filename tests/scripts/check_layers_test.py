#!/usr/bin/python3
"""check_layers.py finds each kind of violation in a made-up tree, and nothing in a clean one."""

import os
import tempfile
import unittest

import check_layers


class CheckLayers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name
        for name in check_layers.MAY_INCLUDE:
            self.write(f"{name}/CMakeLists.txt", f"annulus_library({name}\n  SOURCES a.cpp)\n")
            self.write(f"{name}/a.cpp", "int a;\n")

    def write(self, path, text):
        path = os.path.join(self.root, path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as f:
            f.write(text)

    def found(self):
        return [f"{os.path.relpath(p, self.root)}:{n}: {rule}" for p, n, rule in check_layers.violations(self.root)]

    def test_a_clean_tree_has_no_violation(self):
        self.write("station/a.cpp", '#include <ceres/ceres.h>\n#include "sim/subject.h"\n#include "station/b.h"\n')
        self.assertEqual(self.found(), [])

    def test_a_forbidden_include_is_named_with_its_line(self):
        self.write("fitting/deep/a.h", '#pragma once\n#include "base/result.h"\n#include "sim/subject.h"\n')
        self.assertEqual(self.found(), ["fitting/deep/a.h:3: fitting may not include sim (it may include base)"])

    def test_an_include_upwards_through_dots_is_found(self):
        self.write("base/a.cpp", '#include "../station/config.h"\n')
        self.assertEqual(len(self.found()), 1)

    def test_an_include_without_the_folder_is_found(self):
        self.write("base/a.cpp", '#include "result.h"\n')
        self.assertEqual(len(self.found()), 1)

    def test_a_heavy_header_in_a_header_is_found(self):
        for header in ("ceres/ceres.h", "opencv2/core.hpp", "boost/beast/core.hpp", "Geom_BSplineSurface.hxx", "libusb.h"):
            self.write("modeling/a.h", f"#include <{header}>\n")
            self.assertEqual(self.found(), [f"modeling/a.h:1: <{header}> belongs in .cpp files only"])

    def test_a_second_library_in_a_folder_is_found(self):
        self.write("modeling/mesh/CMakeLists.txt", "add_library(mesh STATIC\n m.cpp)\n")
        self.assertEqual(len(self.found()), 2)

    def test_a_forbidden_link_is_found(self):
        self.write("base/CMakeLists.txt", "annulus_library(base\n  SOURCES a.cpp\n  PUBLIC fitting)\n")
        self.assertEqual(self.found(), ["base/CMakeLists.txt:1: base may not link fitting"])

    def test_a_folder_without_library_and_a_missing_folder_are_found(self):
        self.write("sim/CMakeLists.txt", "# annulus_library(sim SOURCES a.cpp)\n")
        os.rename(os.path.join(self.root, "render"), os.path.join(self.root, "painter"))
        self.assertEqual(len(self.found()), 2)

    def test_two_types_of_one_name_are_found(self):
        self.write("base/a.h", "namespace annulus {\nstruct Level {\n};\n}\n")
        self.write("modeling/b.h", "namespace annulus {\nstruct Level;\nclass Level final : public Base {\n};\n}\n")
        self.assertEqual(self.found(), ["modeling/b.h:3: annulus::Level is also defined in base/a.h"])

    def test_a_file_that_is_too_long_is_found(self):
        self.write("tests/a.cpp", "\n" * 801)
        self.assertEqual(self.found(), ["tests/a.cpp:801: 801 lines, at most 800"])


if __name__ == "__main__":
    unittest.main()
