# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Makes the steps of a plan one after the other, and the page with each."""
import json
import os
import resource
import sys
import time

import links
import page
import stills
from children import Child, Failed
from plan import Build
from progress import spoken


def say(text):
    print(f"demo: {text}", file=sys.stderr, flush=True)


def cpu_seconds():
    """Of this process and of all that it waited for."""
    return sum(usage.ru_utime + usage.ru_stime
               for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


class Runner:
    def __init__(self, plan, state, compiler, forecast, quick):
        """`compiler` is None where programs are there already."""
        self.plan, self.state, self.compiler, self.forecast, self.quick = plan, state, compiler, forecast, quick
        self.built = set()
        self.failed = {}  # {step: why}
        self.stills = {}  # {step: what the page shows of it}
        for file in dict.fromkeys(file for chapter in plan.chapters for section in chapter.sections for part in section.parts
                                  for file in page.files_of(part) if file.endswith(".png")):
            self.stills.setdefault(plan.step_of(file).name, []).append(file)
        self.looks = {}  # {what one of them shows: its file}
        self.status_time = 0.0
        self.shown = False

    def todo(self):
        """What is left, in order; steps of an unknown program count as left."""
        return [step for step in self.plan.steps
                if (step.name not in self.built if isinstance(step, Build) else not self.state.done(step))]

    def build_seconds(self, build):
        """CPU time that the rest of a build takes."""
        left = self.compiler.left(build.target) if self.compiler else (0, 1)
        return build.seconds if left is None else build.seconds * min(1.0, left[0] / left[1])

    def plan_builds(self):
        """Asks ninja, once for each target."""
        self.builds = {step.name: self.build_seconds(step) for step in self.plan.steps if isinstance(step, Build)}

    def left(self, without=None):
        """Wall seconds of what is left, `without` a step that is counted otherwise."""
        return sum(self.forecast.compiling(self.builds[step.name]) if isinstance(step, Build) else self.forecast.wall(self.plan.seconds(step))
                   for step in self.todo() if step is not without and step.name not in self.failed)

    # What is told

    def status(self, text, left, force=False):
        """Rewrites status.js, which the open page reads, at most once a second."""
        now = time.monotonic()
        if force or now - self.status_time > 1:
            self.status_time = now
            steps = [step for step in self.plan.steps if not isinstance(step, Build)]
            done = len(steps) - sum(not isinstance(step, Build) for step in self.todo())
            page.write_status(self.state.out, {"text": text, "done": done, "of": len(steps), "left": f"{spoken(left).capitalize()} left"})

    def write_page(self, ending=None):
        page.write(self.plan, self.state, ending=ending, quick=self.quick, failed=self.failed,
                   programs=self.state.programs)

    # What is done

    def compile(self, build):
        if self.builds[build.name] > 5:
            say(f"compiling {build.target}: {spoken(self.forecast.compiling(self.builds[build.name]))}")
        begin, cpu = time.monotonic(), cpu_seconds()
        last = [begin]

        def told(done, of):
            now = time.monotonic()
            spent = now - begin
            rest = spent / done * (of - done) if done > 8 else max(0.0, self.forecast.compiling(self.builds[build.name]) - spent)
            text = f"Compiling {build.target}: {done} of {of} steps" if of else f"Preparing to compile {build.target}"
            self.status(text, rest + self.left(without=build))
            if now - last[0] > 30 and of:
                last[0] = now
                say(f"{done} of {of} compiled; {spoken(rest)} left, then {spoken(self.left(without=build))} for the pictures")

        self.compiler.build(build.target, told)
        self.built.add(build.name)
        self.state.programs_changed()
        spent = cpu_seconds() - cpu
        if spent > 5:
            say(f"{build.target} is built: {time.monotonic() - begin:.0f} s, {spent:.0f} s of CPU time")

    def make(self, step):
        steps = [one for one in self.plan.steps if not isinstance(one, Build)]
        rest = self.left(without=step)
        expected = self.forecast.wall(self.plan.seconds(step))
        begin, cpu = time.monotonic(), cpu_seconds()
        text = f"Making {step.name}"
        if self.plan.seconds(step) > 0.2:
            say(f"[{steps.index(step) + 1}/{len(steps)}] {step.name}; {spoken(rest + expected)} left")
        self.status(text, rest + expected)
        self.state.prepare(step)
        report = None
        if step.command:
            program, *words = step.words
            child = Child([self.state.programs / program, *words, *(["--json"] if program == "volute" else [])], cwd=self.state.out)
            out = child.wait(lambda: self.status(text, rest + max(0.0, expected - (time.monotonic() - begin))))
            report = json.loads(out) if out.lstrip().startswith("{") else None
        else:
            try:
                report = step.work(self.state.out, *step.arguments)
            except (ValueError, ArithmeticError, LookupError, AssertionError) as error:  # of files that are not as expected
                raise Failed(f"{step.work.__module__}.{step.work.__name__}: {error!r}") from error
        spent = cpu_seconds() - cpu
        self.state.finish(step, spent, report)
        self.look_at(step)
        self.forecast.seen(self.plan.seconds(step), time.monotonic() - begin)

    def look_at(self, step):
        """Raises Failed for a picture of the page that shows nothing, or the same as another."""
        try:
            for file in self.stills.get(step.name, ()):
                if stills.is_flat(self.state.out / file):
                    raise Failed(f"{file} has one colour alone")
                same = self.looks.setdefault(stills.digest(self.state.out / file), file)
                if same != file and same not in step.like:
                    raise Failed(f"{file} is the same picture as {same}")
        except Failed:
            self.state.forget(step)
            raise

    def blocked(self, step):
        """An input or a program that the step needs and that could not be made; None where all is there."""
        if step.command and f"build of {step.words[0]}" in self.failed:
            return step.words[0]
        return next((file for file in step.reads if self.plan.maker[file].name in self.failed), None)

    def run(self):
        """Makes all that is left. Returns whether everything was made; KeyboardInterrupt leaves a page that is right."""
        self.plan_builds()
        self.write_page()
        try:
            for step in self.plan.steps:
                self.one(step)
        except KeyboardInterrupt:
            self.write_page(ending="stopped")
            raise
        self.state.drop_strangers()
        self.write_page(ending="failed" if self.failed else "done")
        for where, target in links.dead(self.state.out):
            say(f"{where}: nothing is at {target}")
        return not self.failed

    def one(self, step):
        try:
            if isinstance(step, Build):
                if self.compiler:
                    self.compile(step)
                else:
                    self.built.add(step.name)
                    return
            elif self.state.done(step):
                self.look_at(step)
                return
            elif self.blocked(step):
                self.failed[step.name] = f"needs {self.blocked(step)}"
                return
            else:
                self.make(step)
        except (Failed, OSError) as error:
            self.failed[step.name] = str(error)
            say(f"{step.name}: {error}")
        pictures = isinstance(step, Build) or any(page.is_shown(file) for file in step.makes)
        if pictures:
            self.write_page()
        if not self.shown and not isinstance(step, Build) and any(page.is_shown(file) for file in step.makes) and not self.failed:
            self.shown = True
            print(f"The first picture: {os.path.relpath(self.state.out / step.name)}\n"
                  f"The page, which grows: {os.path.relpath(self.state.out / 'index.html')}", flush=True)
