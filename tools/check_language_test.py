#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of check_language.py: `python3 tools/check_language_test.py`."""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_language


class Language(unittest.TestCase):
    def faults(self, name, text):
        return list(check_language.faults_in(name, text))

    def test_words_with_another_name_are_found(self):
        for text in ("drawn by the processor", "double processorSeconds();", "class ProcessorThread;", "struct SceneWish {", "as they wish"):
            self.assertEqual(len(self.faults("src/volute/gl/a.cpp", text)), 1, text)

    def test_words_that_only_contain_one_are_not(self):
        for text in ("a post-processor draws it", "#if PREPROCESSED // by the preprocessor", "momentum", "wishbone"):
            self.assertEqual(self.faults("src/volute/cli/a.cpp", text), [], text)

    def test_moments_are_of_times_only_where_nothing_else_has_any(self):
        self.assertEqual(len(self.faults("docs/a.md", "at that moment")), 1)
        self.assertEqual(self.faults("src/volute/wavelet/a.cpp", "vanishing moments of the wavelet"), [])

    def test_phrases_that_nobody_would_say_are_found(self):
        for text in ("by exact integrals where others step", "'x.abc' is of no known format; expected .png", "\"'{}' are no bounds; expected\"",
                     "--a says nothing without --b", "two corners, the least first", "which one of a file with several",
                     "an FDS case, which says itself what its files hold"):
            self.assertEqual(len(self.faults("src/volute/cli/a.cpp", text)), 1, text)

    def test_phrases_of_pages_are_found_there_alone(self):
        for text in ("open like a doll's house", "a made-up fire", "files of strangers", "a stranger's scene", "the same command goes on from there",
                     "an interrupted run goes on where it stopped", "the mean in the place of the value"):
            self.assertEqual(len(self.faults("docs/a.md", text)), 1, text)
            self.assertEqual(self.faults("src/volute/fds/a.hpp", text), [], text)
        for text in ("goes on for 3 s", "which one of the two", "a file that is made up of three parts", "in place of"):
            self.assertEqual(self.faults("docs/a.md", text), [], text)

    def test_the_place_and_the_better_word_are_said(self):
        self.assertEqual(self.faults("bench/a.cpp", "\n  of processor time"), ["bench/a.cpp:2: 'processor' is called CPU here: of processor time"])


if __name__ == "__main__":
    unittest.main()
