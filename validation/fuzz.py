#!/usr/bin/env python3
"""Gives the program damaged input and looks for panics, hangs and unexplained ends.

    validation/fuzz.py [--program target/release/undula] [--seconds 3600] [--seed 1] [--kinds case,set,mesh,run] [--keep DIR]

Kinds: `case` mutates the text of case files, `set` values of the command line, `mesh` the text or bytes of Gmsh files,
`run` the files of an interrupted run before it is resumed, compared, plotted. A finding is an exit code other than 0, 1, 2,
3 and 130, the word `panicked`, no message with an exit code 1 or 2, or more than --limit seconds of processor time (which
may be honest work: the input is kept). Findings are kept in --keep and counted at the end; the exit code is 1 if there are any.
Nothing but Python is needed. The same seed gives the same inputs.
"""
import argparse
import collections
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

CASE = """name = "fuzz"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 1]
cells = [4, 2]
refine = 0
[mesh.region]
solid = "min(min(x-0.5,1-x),0.5-y)"
[space]
velocity = "Q2"
[fluid]
density = 1.0
kinematic-viscosity = 0.01
body-force = [0, "0.1*sin(t)"]
[solid]
density = 10
young = 1e3
poisson = 0.3
law = "st-venant-kirchhoff"
[motion]
model = "pseudo-elastic"
offset = 0.01
[boundary.left]
condition = "velocity"
velocity = ["4*y*(1-y)*ramp(t, 0.1)", 0]
[boundary.right]
condition = "do-nothing"
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[time]
scheme = "backward-euler"
step = 0.05
end = 0.2
max-halvings = 2
[newton]
tolerance = 1e-8
max-steps = 20
[functional.drag]
kind = "force"
on = ["interface"]
component = "x"
[functional.ux]
kind = "displacement"
point = [0.75, 0.5]
component = "x"
[output]
fields-every = 2
checkpoint-every = 2
"""

# Values that are awkward somewhere.
VALUES = """0 -0.0 -1 1 2 3 1e-300 1e300 -1e300 inf -inf nan 9223372036854775807 -9223372036854775808 9223372036854775808 1e-20
"" "x" "1/0" "0/0" "x/y" "sqrt(-1-x)" "log10(0*x)" "exp(1e4*x)" "t" "1/t" "1/(t-0.1)" "x^y^x^y" "-x" "--x" "((((x))))" "if(x,y,t)"
"if(t<0.1,1,0/0)" "if(1<2,x,if(1<2,y,t))" "min(x)" "max()" "step(t)" "pi" "e" "z" "none" "é" "🦀" "a\\u0000b" true false none [] [1]
[0,0] [1,2,3] [[]] [[1,2],[3,4]] ["x","y"] {} {a=1} 1979-05-27 0x7fffffff 0b1 1_000 "interface" "solid" "fluid" "left" "../x" "/" "Q1" "Q4"
"P2" "P2-bubble" "P1dc" "P2dc" "stationary" "bdf2" "cg1" "fractional-step-theta" "rannacher" "newton" "reduced" "fixed-point" "condensed"
"clamped" "do-nothing" "traction-free" "velocity" "biharmonic" "harmonic" "neo-hookean" "incompressible-neo-hookean\"""".split()

KEYS = """name title mesh.generator mesh.lower mesh.upper mesh.cells mesh.refine mesh.grading mesh.file mesh.region.solid space.velocity
space.pressure space.quadrature fluid.density fluid.kinematic-viscosity fluid.body-force fluid.body-force-at fluid.region solid.density
solid.mu solid.lambda solid.young solid.poisson solid.law solid.body-force solid.region motion.model motion.offset motion.exponent
motion.walls motion.poisson boundary.left.condition boundary.left.velocity boundary.right.condition boundary.top.condition time.scheme
time.step time.start time.end time.theta time.max-halvings time.adaptive.tolerance time.adaptive.min-step newton.linearization
newton.jacobian newton.rate-max newton.tolerance newton.floor newton.max-steps newton.secants newton.line-search linear.solver
linear.precision linear.refinement linear.krylov functional.drag.on functional.drag.kind functional.ux.point functional.ux.component
output.fields-every output.fields-interval output.checkpoint-every output.deformed stabilization.pressure stabilization.transport fluid
solid time boundary mesh""".split()

EXPRESSION = ["x", "y", "t", "1", "0", "pi", "1e308", "(", ")", ",", "+", "-", "*", "/", "^", "<", ">=", "sin(", "sqrt(", "if(", "min(", "ramp(",
              "atan2(", "clamp(", "step(", " ", "1e", ".", "e5", "ln("]


def mesh():
    """A small Gmsh file, version 4.1: two by two quadrilaterals, a solid beside a fluid."""
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", "6", '1 1 "left"', '1 2 "right"', '1 3 "walls"',
             '1 4 "clamp"', '2 5 "fluid"', '2 6 "solid"', "$EndPhysicalNames", "$Entities", "0 4 2 0"]
    for tag, group in ((1, 1), (2, 2), (3, 3), (4, 4)):
        lines.append(f"{tag} 0 0 0 2 2 0 1 {group} 0")
    for tag, group in ((1, 5), (2, 6)):
        lines.append(f"{tag} 0 0 0 2 2 0 1 {group} 0")
    lines += ["$EndEntities", "$Nodes", "1 9 1 9", "2 1 0 9"] + [str(n) for n in range(1, 10)]
    lines += [f"{x} {y} 0" for y in range(3) for x in range(3)]
    facets = {1: [(1, 4), (4, 7)], 2: [(3, 6), (6, 9)], 3: [(1, 2), (7, 8), (8, 9)], 4: [(2, 3)]}
    cells = {1: [(1, 2, 5, 4), (4, 5, 8, 7), (5, 6, 9, 8)], 2: [(2, 3, 6, 5)]}
    lines += ["$EndNodes", "$Elements"]
    blocks, tag = [], 0
    for dimension, kind, entities in ((1, 1, facets), (2, 3, cells)):
        for entity, elements in entities.items():
            blocks.append(f"{dimension} {entity} {kind} {len(elements)}")
            for nodes in elements:
                tag += 1
                blocks.append(" ".join(map(str, (tag, *nodes))))
    lines += [f"6 {tag} 1 {tag}"] + blocks + ["$EndElements", ""]
    return "\n".join(lines).encode()


MESH_CASE = CASE.replace('generator = "box"\nlower = [0, 0]\nupper = [2, 1]\ncells = [4, 2]\n', 'file = "fuzz.msh"\n').replace(
    '[mesh.region]\nsolid = "min(min(x-0.5,1-x),0.5-y)"\n', "").replace("boundary.top", "boundary.walls").replace(
    '[boundary.bottom]\ncondition = "no-slip"', '[boundary.clamp]\ncondition = "clamped"').replace("[0.75, 0.5]", "[2, 0.5]")


class Fuzzer:
    def __init__(self, options):
        self.options = options
        self.program = os.path.abspath(options.program)
        self.here = os.path.abspath(options.keep)
        self.scratch = os.path.join(self.here, "scratch")
        self.counts = collections.Counter()
        self.findings = []
        os.makedirs(self.here, exist_ok=True)

    def run(self, *arguments):
        """Exit code and all that was said; None for a hang."""
        def limits():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (self.options.memory << 20,) * 2)
            resource.setrlimit(resource.RLIMIT_CPU, (int(self.options.limit) + 1,) * 2)
        process = subprocess.Popen([self.program, *arguments], cwd=self.scratch, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=limits)
        try:
            out, err = process.communicate(timeout=50 * self.options.limit)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None, ""
        if process.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            return None, ""
        return process.returncode, (out + err).decode(errors="replace")

    def judge(self, kind, number, arguments):
        code, said = self.run(*arguments)
        self.counts[f"{kind}: exit {code}" if code is not None else f"{kind}: too long"] += 1
        wrong = None
        if code is None:
            wrong = f"longer than {self.options.limit} s"
        elif "panicked" in said:
            wrong = "panic"
        elif code not in (0, 1, 2, 3, 130):
            wrong = f"exit code {code}"
        elif code in (1, 2) and not said.strip():
            wrong = "no message"
        if wrong:
            name = os.path.join(self.here, f"{kind}-{number}")
            shutil.rmtree(name, ignore_errors=True)
            shutil.copytree(self.scratch, name)
            with open(os.path.join(name, "said"), "w") as file:
                file.write(f"{' '.join(arguments)}\n{wrong}\n{said}")
            self.findings.append(name)
            print(f"{name}: {wrong}: {' '.join(arguments)}: {said[:300]}", flush=True)
        return code

    def write(self, name, content):
        path = os.path.join(self.scratch, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())

    def try_case(self, kind, number, arguments):
        """`check`, and a run where that accepts the case."""
        if self.judge(kind, number, ["check", *arguments]) == 0:
            self.judge(kind, number, ["run", *arguments, "-o", "out", "--threads", "1", "--quiet", "--force"])

    def expression(self, dice):
        if dice.random() < 0.2:
            depth = dice.choice([3, 20, 60, 70, 500])
            return "(" * depth + "x" + ")" * depth
        return "".join(dice.choice(EXPRESSION) for _ in range(dice.randint(1, 12)))

    def value(self, dice):
        return f'"{self.expression(dice)}"' if dice.random() < 0.3 else dice.choice(VALUES)

    def case(self, dice, number):
        lines = CASE.splitlines()
        for _ in range(dice.choice([1, 1, 1, 2, 5])):
            i = dice.randrange(len(lines))
            how = dice.random()
            if how < 0.5 and " = " in lines[i]:
                lines[i] = lines[i].split(" = ")[0] + " = " + self.value(dice)
            elif how < 0.6:
                lines.insert(dice.randrange(len(lines)), lines[i])
            elif how < 0.7:
                del lines[i]
            elif how < 0.8:
                lines[i] = "[" + "a." * dice.choice([1, 50, 2000]) + "b]"
            else:
                lines[i] = damaged(dice, lines[i].encode()).decode(errors="replace")
        self.write("fuzz.toml", "\n".join(lines))
        self.try_case("case", number, ["fuzz.toml"])

    def set(self, dice, number):
        self.write("fuzz.toml", CASE)
        sets = []
        for _ in range(dice.choice([1, 1, 2, 3])):
            key = dice.choice(KEYS) if dice.random() < 0.95 else damaged(dice, dice.choice(KEYS).encode()).decode(errors="replace")
            sets += ["--set", f"{key}={self.value(dice)}".replace("\0", "")]
        self.try_case("set", number, ["fuzz.toml", *sets])

    def mesh(self, dice, number):
        content = mesh()
        lines = content.split(b"\n")
        for _ in range(dice.choice([1, 1, 2, 4])):
            if not lines:
                break
            i = dice.randrange(len(lines))
            how = dice.random()
            if how < 0.5 and lines[i].split():
                words = lines[i].split()
                words[dice.randrange(len(words))] = dice.choice(
                    [b"0", b"-1", b"1e400", b"nan", b"99999999999999999999", b"4294967296", b"2147483647", b"x", b"", b"1.5", b"3"])
                lines[i] = b" ".join(words)
            elif how < 0.6:
                del lines[i]
            elif how < 0.7:
                lines.insert(dice.randrange(len(lines)), lines[i])
            elif how < 0.8:
                lines = lines[:i + 1]
            else:
                lines[i] = damaged(dice, lines[i])
        self.write("fuzz.msh", b"\n".join(lines))
        self.write("fuzz.toml", MESH_CASE)
        self.try_case("mesh", number, ["fuzz.toml"])

    def of_run(self, dice, number):
        """Damages the files of a run; `self.prepared` holds a good one."""
        shutil.copytree(self.prepared, os.path.join(self.scratch, "out"), dirs_exist_ok=True)
        files = [os.path.join(folder, name) for folder, _, names in os.walk(os.path.join(self.scratch, "out")) for name in names]
        files.sort()
        for _ in range(dice.choice([1, 1, 2])):
            name = dice.choice(files)
            if not os.path.exists(name):
                continue
            with open(name, "rb") as file:
                content = file.read()
            how = dice.random()
            if how < 0.1:
                os.remove(name)
                continue
            if how < 0.2:
                content = b""
            elif how < 0.4:
                content = content[:dice.randrange(len(content) + 1)]
            else:
                content = damaged(dice, content, dice.choice([1, 3, 30]))
            with open(name, "wb") as file:
                file.write(content)
        commands = [["compare", "out"], ["plot", "out"], ["check", "--from", "out"],
                    ["run", "out/case.toml", "-o", "out", "--threads", "1", "--quiet", "--resume", "--set", "time.end=0.3"]]
        for command in dice.sample(commands, 2):
            self.judge("run", number, command)

    def prepare(self):
        """A run to damage."""
        shutil.rmtree(self.scratch, ignore_errors=True)
        os.makedirs(self.scratch)
        self.write("fuzz.toml", CASE)
        code, said = self.run("run", "fuzz.toml", "-o", "out", "--threads", "1", "--force")
        if code != 0:
            sys.exit(f"the case itself does not run: {code}\n{said}")
        self.prepared = os.path.join(self.here, "prepared")
        shutil.rmtree(self.prepared, ignore_errors=True)
        shutil.move(os.path.join(self.scratch, "out"), self.prepared)

    def go(self):
        self.prepare()
        kinds = self.options.kinds.split(",")
        methods = {"case": self.case, "set": self.set, "mesh": self.mesh, "run": self.of_run}
        begun, number = time.monotonic(), self.options.first
        while time.monotonic() - begun < self.options.seconds:
            kind = kinds[number % len(kinds)]
            shutil.rmtree(self.scratch, ignore_errors=True)
            os.makedirs(self.scratch)
            methods[kind](random.Random(f"{self.options.seed}-{number}"), number)
            number += 1
        shutil.rmtree(self.scratch, ignore_errors=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{time.monotonic() - begun:.0f} s, {used.ru_utime + used.ru_stime:.0f} s of the program on a processor")
        print(f"{number - self.options.first} inputs, {sum(self.counts.values())} runs of the program, "
              f"{len(self.findings)} findings")
        for name, count in sorted(self.counts.items()):
            print(f"  {name}: {count}")
        return 1 if self.findings else 0


def damaged(dice, content, times=1):
    """`content` with some bytes changed, inserted, repeated or removed."""
    content = bytearray(content)
    for _ in range(times):
        at = dice.randrange(len(content) + 1)
        how = dice.randrange(4)
        if how == 0 and at < len(content):
            content[at] = dice.randrange(256)
        elif how == 1:
            content[at:at] = bytes(dice.choice([b"\0", b"-", b"9", b"e", b"\n", b"\xff", b"[", b'"', b"999999999"]))
        elif how == 2:
            del content[at:at + dice.choice([1, 2, 10])]
        else:
            content[at:at] = content[at:at + dice.choice([1, 5, 50])]
    return bytes(content)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/undula")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first input, to repeat one")
    parser.add_argument("--kinds", default="case,set,mesh,run")
    parser.add_argument("--limit", type=float, default=60, help="processor seconds after which a run of the program counts as hanging")
    parser.add_argument("--memory", type=int, default=8192, help="MiB of address space of the program")
    parser.add_argument("--keep", default="out/fuzz", help="directory for findings")
    sys.exit(Fuzzer(parser.parse_args()).go())


if __name__ == "__main__":
    main()
