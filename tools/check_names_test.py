#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of check_names.py: `python3 tools/check_names_test.py`."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_names


class Names(unittest.TestCase):
    def names(self, text):
        return list(check_names.types_of(text))

    def test_types_at_namespace_scope_have_qualified_names(self):
        self.assertEqual(self.names("""
            // struct Comment {};
            namespace volute::cli {
            struct A { struct Inner {}; enum class Kind { kOne }; };
            class B final : public A { void f() { struct Local {}; } };
            template <class T> class C {};
            template <> class C<int> {};
            enum class D : int { kOne };
            struct Declared;
            const char* kText = R"(struct Text {)";
            namespace detail { union E { int a; }; }
            namespace { struct Own {}; }
            struct F {};
            }"""), ["volute::cli::" + name for name in ("A", "B", "C", "D", "detail::E", "F")])

    def test_the_same_name_twice_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            (place / "a.hpp").write_text("namespace n { struct S {}; }")
            (place / "b.cpp").write_text("namespace n { struct S { int a; }; namespace { struct T {}; } }")
            (place / "c.cpp").write_text("namespace n { namespace { struct T {}; } }")
            (place / "d_test.cpp").write_text("namespace n { struct S {}; }")
            self.assertEqual(check_names.doubles([folder]), {"n::S": {str(place / "a.hpp"), str(place / "b.cpp")}})

    def test_a_private_name_of_two_sources_of_a_folder_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            (place / "a.cpp").write_text("namespace {\nconstexpr int kA = 1, kC = 2;\nenum Column { kFirst, kD = kA,\n  kLast };\nint f(int a, double b) {\n  return 0;\n}\n}  // namespace\n")
            (place / "b.cpp").write_text("namespace {\nconst double kA[] = {1};\nint f(int a, double c) {\n  return 1;\n}\nint f(int a) { return 1; }\n}  // namespace\n")
            (place / "c_test.cpp").write_text("namespace {\nconstexpr int kA = 1;\n}  // namespace\n")
            (place / "d.cpp").write_text("namespace {\nconst char* const kFirst = \"x\";\nenum class Kind { kLast };\n}  // namespace\n")
            both = {str(place / "a.cpp"), str(place / "b.cpp")}
            self.assertEqual(check_names.clashes([folder]), {"kA": both, "f(int, double)": both, "kFirst": {str(place / "a.cpp"), str(place / "d.cpp")}})


if __name__ == "__main__":
    unittest.main()
