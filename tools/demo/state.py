# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What is made already: a record for each step, so that a second run makes nothing again that is there."""
import fcntl
import hashlib
import inspect
import json
import pathlib
import shutil

FOLDER = ".state"


def digest(*parts):
    """Of texts and bytes."""
    whole = hashlib.sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else str(part).encode()
        whole.update(len(data).to_bytes(8, "little") + data)
    return whole.hexdigest()


def measure(path):
    """Size and time of a file; of a folder, number and bytes of its files. None where there is nothing."""
    if path.is_dir():
        sizes = [file.stat().st_size for file in path.rglob("*") if file.is_file()]
        return [len(sizes), sum(sizes)]
    return [path.stat().st_size, path.stat().st_mtime_ns] if path.is_file() else None


def remove(path):
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


class NotYet(Exception):
    """Asked of what is not made."""


class State:
    """The records of one output folder, OUT/.state/*.json: {"stamp", "makes": {path: measure}, "seconds", "report"}."""

    def __init__(self, out, plan, programs):
        """`programs` is the folder of the built programs."""
        self.out, self.plan, self.programs = pathlib.Path(out), plan, pathlib.Path(programs)
        self.folder = self.out / FOLDER
        self.folder.mkdir(parents=True, exist_ok=True)
        self.records = {}
        for path in self.folder.glob("*.json"):
            try:
                record = json.loads(path.read_text(encoding="utf-8"))
                self.records[record["name"]] = record
            except (OSError, ValueError, KeyError, TypeError):
                path.unlink(missing_ok=True)  # half a record is none
        self.digests = {}
        self.stamps = {}

    def lock(self):
        """False where another demo writes into this folder."""
        self.locked = open(self.folder / "lock", "w")
        try:
            fcntl.flock(self.locked, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def program(self, name):
        """What tells one version of a program from another: its bytes. A program that is compiled later counts anew."""
        path = self.programs / name
        if name not in self.digests and path.is_file():
            self.digests[name] = digest(path.read_bytes())
        return self.digests.get(name, "missing")

    def programs_changed(self):
        self.digests.clear()
        self.stamps.clear()

    def stamp(self, step):
        """What a step's outputs depend on: its words, its program or its function's whole module, and the same of what it reads."""
        if step.name not in self.stamps:
            if step.command:
                own = (step.command, self.program(step.words[0]))
            else:
                own = (repr(step.arguments), step.work.__name__, pathlib.Path(inspect.getsourcefile(step.work)).read_bytes())
            self.stamps[step.name] = digest(*own, *(self.stamp(self.plan.maker[file]) for file in step.reads))
        return self.stamps[step.name]

    def done(self, step):
        """Whether all that the step makes is there, as it would be made now."""
        record = self.records.get(step.name)
        return (record is not None and record["stamp"] == self.stamp(step) and
                all(record["makes"].get(file) == measure(self.out / file) is not None for file in step.makes))

    def path(self, name):
        return self.folder / (digest(name)[:20] + ".json")

    def prepare(self, step):
        """Makes room for the step's outputs; what is left of earlier ones goes."""
        self.forget(step)
        for file in step.makes:
            target = self.out / file
            remove(target)
            (target if file.endswith("/") else target.parent).mkdir(parents=True, exist_ok=True)

    def finish(self, step, seconds, report):
        made = {file: measure(self.out / file) for file in step.makes}
        missing = [file for file, size in made.items() if size is None or (file.endswith("/") and not size[0])]
        if missing:
            raise OSError(f"{missing[0]} was not made")
        record = {"name": step.name, "stamp": self.stamp(step), "makes": made, "seconds": seconds, "report": report}
        temporary = self.path(step.name).with_suffix(".new")
        temporary.write_text(json.dumps(record), encoding="utf-8")
        temporary.replace(self.path(step.name))
        self.records[step.name] = record

    def forget(self, step):
        """It will be made again."""
        self.records.pop(step.name, None)
        self.path(step.name).unlink(missing_ok=True)

    def drop_strangers(self):
        """Removes what earlier runs made and this one does not: files that this plan makes stay."""
        for name in [name for name in self.records if name not in self.plan.maker]:
            for file in self.records[name]["makes"]:
                inside = (self.out / file).resolve().is_relative_to(self.out.resolve())
                if inside and file not in self.plan.maker:
                    remove(self.out / file)
            self.path(name).unlink(missing_ok=True)
            del self.records[name]

    def report(self, file):
        """What the command that made this file printed with --json. Raises NotYet."""
        step = self.plan.step_of(file)
        if not self.done(step):
            raise NotYet(file)
        return self.records[step.name]["report"]

    def size(self, *files):
        """Bytes on disk, of the contents of folders too. Raises NotYet."""
        total = 0
        for file in files:
            size = measure(self.out / file)
            if size is None:
                raise NotYet(file)
            total += size[1 if file.endswith("/") else 0]
        return total

    def seconds(self):
        """{step: CPU time of what is made}."""
        return {name: record["seconds"] for name, record in self.records.items()}
