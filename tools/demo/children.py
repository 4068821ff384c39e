# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Programs that run while the demo keeps its page alive."""
import queue
import subprocess
import threading


class Failed(Exception):
    """A program ended with an error: one sentence, what it said last."""


class Child:
    """A program whose lines are read as they come. It shares the terminal's process group, so Ctrl-C reaches it too."""

    def __init__(self, words, cwd, env=None):
        self.words = [str(word) for word in words]
        try:
            self.process = subprocess.Popen(self.words, cwd=cwd, env=env, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                            stderr=subprocess.PIPE, text=True, errors="replace")
        except OSError as error:
            raise Failed(f"{self.words[0]}: {error.strerror}") from error
        self.lines = queue.SimpleQueue()
        self.out, self.said = [], []

    def read(self, stream, keep):
        for line in stream:
            keep.append(line)
            self.lines.put(line)
        self.lines.put(None)

    def wait(self, tick=lambda: None, line=lambda text: None, seconds=1.0):
        """Standard output, once the program has ended well. `tick` is called every second, `line` for each line."""
        readers = [threading.Thread(target=self.read, args=pair, daemon=True)
                   for pair in ((self.process.stdout, self.out), (self.process.stderr, self.said))]
        for reader in readers:
            reader.start()
        try:
            open_streams = len(readers)
            while open_streams:
                try:
                    text = self.lines.get(timeout=seconds)
                    open_streams -= text is None
                    line(text or "")
                except queue.Empty:
                    pass
                tick()
            self.process.wait()
        except BaseException:
            self.stop()
            raise
        if self.process.returncode != 0:
            raise Failed(f"{self.words[0]} ended with {self.process.returncode}: {self.last_words()}")
        return "".join(self.out)

    def last_words(self):
        """What the compiler or the program complained of: the end of its standard error, else of its output."""
        said = "".join(self.said).strip() or "".join(self.out).strip()
        return said[-2000:] or "it said nothing"

    def stop(self):
        """Ends the program, gently first: it takes its unfinished files away."""
        self.process.terminate()
        try:
            self.process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
