# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""How long calls tell what they do."""
import logging

_log = logging.getLogger("volute")
_WARNINGS = ("doubtful", "changed", "damaged", "left-out")


class Listener:
    """Hears a long call. `progress` is None, a function (stage, done, total) or True: a bar by tqdm where that is installed.
    Remarks go to the logger "volute", with `code`, `file`, `place` and `hints`: as warnings where the result may not be what was
    expected. `told`: a set of those of earlier calls, which are not said again."""

    def __init__(self, progress=None, told=None):
        if progress is not None and progress is not True and progress is not False and not callable(progress):
            raise TypeError("progress: expected a function (stage, done, total), True or None")
        self._call = progress if callable(progress) else None
        self._told = told
        self._bars = None
        if progress is True:
            try:
                from tqdm.auto import tqdm
                self._bars = tqdm
            except ImportError:
                self._call = self._log_tenths
        self._bar = None
        self._stage = None
        self._tenth = -1

    def report(self, stage, done, total):
        if self._call:
            self._call(stage, done, total)
        elif self._bars:
            if stage != self._stage:
                self.close()
                self._stage, self._bar = stage, self._bars(total=total or None, desc=stage, leave=False)
            self._bar.update(done - self._bar.n)

    def remark(self, text, code="note", file="", place="", hints=()):
        if self._told is not None:
            if text in self._told:
                return
            self._told.add(text)
        level = logging.WARNING if code in _WARNINGS else logging.INFO
        _log.log(level, "%s", text, extra={"code": code, "file": file, "place": place, "hints": list(hints)})

    def _log_tenths(self, stage, done, total):
        tenth = int(10 * done / total) if total else 0
        if (stage, tenth) != (self._stage, self._tenth):
            self._stage, self._tenth = stage, tenth
            _log.warning("%s: %g of %g", stage, done, total)

    def close(self):
        if self._bar is not None:
            self._bar.close()
        self._bar = None

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()
