# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Completion scripts and the manual page, as far as the shells and groff that are there can check them."""
import shutil
import subprocess

import support


class Shell(support.TestCase):
    def complete(self, *words):
        script = self.works("completion", "bash").text
        words = " ".join(f"'{word}'" for word in words)
        script += f"\nCOMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _volute; printf '%s\n' \"${{COMPREPLY[@]}}\"\n"
        done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=30)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def test_bash_completes(self):
        self.assertEqual(self.complete("volute", "comp"), ["compress", "compare", "completion"])
        self.assertEqual(self.complete("volute", "compress", "--rm"), ["--rms", "--rms-over", "--rms-of"])
        self.assertEqual(self.complete("volute", "compress", "--wavelet", "cdf"), ["cdf53", "cdf97"])
        self.assertEqual(self.complete("volute", "completion", "z"), ["zsh"])

    def test_scripts_are_valid(self):
        for shell in ("bash", "zsh", "fish"):
            script = self.works("completion", shell).text
            self.assertIn("extinction", script)
            if shutil.which(shell):
                done = subprocess.run([shell, "-n"], input=script, capture_output=True, text=True, timeout=30)
                self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_manual_holds_every_command(self):
        page = self.works("man").text
        for name in self.works("completion", "bash").text.split("compgen -W '")[-1].split("'")[0].split():
            if not name.startswith("-"):
                self.assertIn(f".SS volute {name}\n", page)
        if shutil.which("groff"):
            done = subprocess.run(["groff", "-man", "-Tascii", "-ww", "-z"], input=page, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    support.main()
