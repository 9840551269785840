#!/usr/bin/env python3
"""Gives the program damaged input and looks for panics, hangs and unexplained ends.

    validation/fuzz.py [--program target/release/undula] [--seconds 3600] [--seed 1] [--kinds case,vtu] [--keep DIR]

Kinds: `case` mutates the text of case files, `set` values of the command line, `expression` formulas, `table` files of values,
`mesh` the text or bytes of Gmsh files, `vtu` those of VTU files, `run` the files of an interrupted run before it is resumed,
compared, plotted, `checkpoint` the arrays and the metadata of its checkpoints, with sums that fit. A finding is an exit code
other than 0, 1, 2, 3 and 130, the word `panicked`, no message with an exit code 1 or 2, more than --limit seconds of processor
time (which may be honest work: the input is kept), or more than --resident MiB where the files ask for little. Findings are
kept in --keep; a table of all kinds is printed at the end, also after SIGTERM; the exit code is 1 if there are findings.
Nothing but Python is needed. The same seed gives the same inputs.
"""
import argparse
import collections
import json
import os
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
import zipfile

import fuzz_files

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

FUNCTIONS = [("sin", 1), ("sqrt", 1), ("exp", 1), ("ln", 1), ("log10", 1), ("abs", 1), ("floor", 1), ("acos", 1), ("tan", 1),
             ("min", 2), ("max", 2), ("pow", 2), ("hypot", 2), ("atan2", 2), ("step", 1), ("if", 3), ("clamp", 3), ("ramp", 2)]

# Keys that take an expression.
PLACES = ["boundary.left.velocity=[#,0]", "boundary.left.velocity=[0,#]", "fluid.body-force=[0,#]", "solid.body-force=[#,0]",
          "mesh.region.solid=#", "time.step=#", "boundary.right={condition=\"pressure\",pressure=#}",
          "boundary.bottom={condition=\"clamped\"}", "boundary.top={condition=\"displacement\",displacement=[0,#]}"]

EXPRESSION = ["x", "y", "t", "1", "0", "pi", "1e308", "(", ")", ",", "+", "-", "*", "/", "^", "<", ">=", "sin(", "sqrt(", "if(", "min(", "ramp(",
              "atan2(", "clamp(", "step(", " ", "1e", ".", "e5", "ln("]


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
        self.tally = {kind: collections.Counter() for kind in options.kinds.split(",")}
        self.findings = []
        os.makedirs(self.here, exist_ok=True)

    def run(self, *arguments):
        """Exit code, all that was said, processor seconds, MiB; the code is None for a hang."""
        def limits():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (self.options.memory << 20,) * 2)
            resource.setrlimit(resource.RLIMIT_CPU, (int(self.options.limit) + 1,) * 2)
        with open(os.path.join(self.here, "said"), "w+b") as said:
            process = subprocess.Popen([self.program, *arguments], cwd=self.scratch, stdin=subprocess.DEVNULL,
                                       stdout=said, stderr=said, preexec_fn=limits)
            timer = threading.Timer(50 * self.options.limit, process.kill)
            timer.daemon = True
            timer.start()
            _, status, usage = os.wait4(process.pid, 0)
            timer.cancel()
            process.returncode = code = os.waitstatus_to_exitcode(status)
            said.seek(0)
            text = said.read().decode(errors="replace")
        if code in (-signal.SIGXCPU, -signal.SIGKILL):
            code = None
        return code, text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss // 1024

    def judge(self, kind, number, arguments):
        code, said, seconds, memory = self.run(*arguments)
        self.counts[f"{kind}: exit {code}" if code is not None else f"{kind}: too long"] += 1
        tally = self.tally[kind]
        tally["runs"] += 1
        tally["seconds"] += seconds
        tally["memory"] = max(tally["memory"], memory)
        tally["slowest"] = max(tally["slowest"], seconds)
        wrong = None
        if code is None:
            wrong = f"longer than {self.options.limit} s"
        elif "panicked" in said:
            wrong = "panic"
        elif code not in (0, 1, 2, 3, 130):
            wrong = f"exit code {code}"
        elif code in (1, 2) and not said.strip():
            wrong = "no message"
        elif kind not in ("case", "set") and memory > self.options.resident:
            wrong = f"{memory} MiB"
        if wrong:
            name = os.path.join(self.here, f"{kind}-{number}")
            shutil.rmtree(name, ignore_errors=True)
            shutil.copytree(self.scratch, name)
            with open(os.path.join(name, "said"), "w") as file:
                file.write(f"{' '.join(arguments)}\n{wrong}\n{said}")
            self.findings.append(name)
            tally["findings"] += 1
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

    def formula(self, dice, depth=0):
        """A sound formula, mostly; its numbers may be anything."""
        how = dice.random()
        if depth > 5 or how < 0.3:
            return dice.choice(["x", "y", "t", "pi", "0", "1", "-1", "0.5", "2", "1e-300", "1e300", "1e-9", "table('fuzz.csv',t)"])
        inside = lambda: self.formula(dice, depth + 1)
        if how < 0.65:
            return f"({inside()}{dice.choice(['+', '-', '*', '/', '^', '<', '>', '<=', '>=', '==', '!='])}{inside()})"
        name, n = dice.choice(FUNCTIONS)
        n = n if dice.random() < 0.97 else n + dice.choice([-1, 1])
        return f"{name}({','.join(inside() for _ in range(n))})"

    def expressions(self, dice, number):
        self.write("fuzz.toml", CASE)
        self.write("fuzz.csv", fuzz_files.TABLE)
        sets = []
        for place in dice.sample(PLACES, dice.choice([1, 1, 2])):
            text = self.formula(dice)
            if dice.random() < 0.4:
                text = damaged(dice, text.encode(), dice.choice([1, 1, 4])).decode(errors="replace").replace("\0", "")
            if place.startswith("time.step"):
                # Any number of tiny steps is honest work.
                text = f"max(0.01,{text})"
            sets += ["--set", place.replace("#", json.dumps(text))]
        self.try_case("expression", number, ["fuzz.toml", *sets])

    def table(self, dice, number):
        content = fuzz_files.TABLE
        lines = content.split(b"\n")
        for _ in range(dice.choice([1, 1, 2, 4])):
            i = dice.randrange(len(lines))
            how = dice.random()
            if how < 0.4:
                words = lines[i].split(b",")
                words[dice.randrange(len(words))] = dice.choice(
                    [b"0", b"-1", b"1e400", b"nan", b"inf", b"x", b"", b"1;5", b"3", b"1e-320", b"1e308", b"-1e308", b"#"])
                lines[i] = dice.choice([b",", b",", b",", b";", b"\t", b" "]).join(words)
            elif how < 0.5:
                lines.insert(i, lines[i])
            elif how < 0.6:
                lines = lines[:i] or [b""]
            else:
                lines[i] = damaged(dice, lines[i])
        self.write("fuzz.csv", b"\n".join(lines))
        how = dice.choice(["", ',"linear"', ',"cubic"', ',"periodic"', ',"cubic periodic"', ',"cubik"'])
        self.write("fuzz.toml", CASE.replace('"4*y*(1-y)*ramp(t, 0.1)"', f"'4*y*(1-y)*table(\"fuzz.csv\",t{how})'"))
        self.try_case("table", number, ["fuzz.toml"])

    def mesh(self, dice, number):
        content = dice.choice([fuzz_files.gmsh4, fuzz_files.gmsh4, fuzz_files.gmsh2, fuzz_files.gmsh4_bytes])()
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

    def vtu(self, dice, number):
        content = fuzz_files.vtu(dice.choice(["ascii", "binary", "raw"]))
        for _ in range(dice.choice([1, 1, 2, 4])):
            how = dice.random()
            if how < 0.5:
                # A word or a value in quotes becomes another one.
                words = re.findall(rb'[\w.+/=-]+', content)
                word = dice.choice(words or [b""])
                places = [m.start() for m in re.finditer(re.escape(word), content)]
                at = dice.choice(places)
                other = dice.choice(words + [b"0", b"-1", b"1e400", b"nan", b"9223372036854775807", b"4294967295", b"x", b"", b"1.5"])
                content = content[:at] + other + content[at + len(word):]
            elif how < 0.6:
                content = content[:dice.randrange(len(content) + 1)]
            else:
                content = damaged(dice, content)
        self.write("fuzz.vtu", content)
        self.write("fuzz.toml", MESH_CASE.replace("fuzz.msh", "fuzz.vtu"))
        self.try_case("vtu", number, ["fuzz.toml"])

    def checkpoint(self, dice, number):
        """Damages what is in the checkpoints; their sums fit again, so that it is read."""
        out = os.path.join(self.scratch, "out")
        shutil.copytree(self.prepared, out, dirs_exist_ok=True)
        folder = os.path.join(out, "checkpoints")
        for name in sorted(os.listdir(folder)):
            path = os.path.join(folder, name)
            with zipfile.ZipFile(path) as archive:
                members = {member: archive.read(member) for member in archive.namelist()}
            for _ in range(dice.choice([1, 1, 2, 5])):
                member = dice.choice(sorted(members))
                content = members[member]
                how = dice.random()
                if how < 0.1:
                    del members[member]
                    if not members:
                        break
                elif how < 0.3:
                    members[member] = content[:dice.randrange(len(content) + 1)]
                elif how < 0.5 and len(content) > 128:
                    # The numbers behind the header of an array.
                    at = 8 * dice.randrange(16, len(content) // 8) if len(content) >= 136 else 120
                    wild = dice.choice([float("nan"), float("inf"), 1e308, -1e-320, 1e30])
                    members[member] = content[:at] + struct.pack("<d", wild) + content[at + 8:]
                elif how < 0.7:
                    digits = [m.span() for m in re.finditer(rb"[0-9]+", content[:4000])]
                    if digits:
                        start, end = dice.choice(digits)
                        wild = dice.choice([b"0", b"1", b"-1", b"18446744073709551615", b"1e308", b"99999999", b"null", b'"x"'])
                        members[member] = content[:start] + wild + content[end:]
                else:
                    members[member] = damaged(dice, content, dice.choice([1, 3]))
            with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
                for member, content in members.items():
                    archive.writestr(member, content)
        self.write("fuzz.toml", CASE)
        again = ["--threads", "1", "--quiet", "--set", "time.end=0.3"]
        for command in (["run", "out/case.toml", "-o", "out", "--resume", *again],
                        ["run", "fuzz.toml", "-o", "other", "--force", "--set", "initial.from=out", *again]):
            self.judge("checkpoint", number, command)

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
        code, said, _, _ = self.run("run", "fuzz.toml", "-o", "out", "--threads", "1", "--force")
        if code != 0:
            sys.exit(f"the case itself does not run: {code}\n{said}")
        self.prepared = os.path.join(self.here, "prepared")
        shutil.rmtree(self.prepared, ignore_errors=True)
        shutil.move(os.path.join(self.scratch, "out"), self.prepared)

    def go(self):
        self.prepare()
        kinds = list(self.tally)
        methods = {"case": self.case, "set": self.set, "expression": self.expressions, "table": self.table, "mesh": self.mesh,
                   "vtu": self.vtu, "run": self.of_run, "checkpoint": self.checkpoint}
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(self.told(begun, number)))
        begun, number = time.monotonic(), self.options.first
        while time.monotonic() - begun < self.options.seconds:
            kind = kinds[number % len(kinds)]
            shutil.rmtree(self.scratch, ignore_errors=True)
            os.makedirs(self.scratch)
            started = time.monotonic()
            methods[kind](random.Random(f"{self.options.seed}-{number}"), number)
            self.tally[kind]["hours"] += (time.monotonic() - started) / 3600
            self.tally[kind]["inputs"] += 1
            number += 1
        shutil.rmtree(self.scratch, ignore_errors=True)
        return self.told(begun, number)

    def told(self, begun, number):
        print(f"{time.monotonic() - begun:.0f} s, {number - self.options.first} inputs, {sum(self.counts.values())} runs of the "
              f"program, {len(self.findings)} findings")
        print("| kind | hours | inputs | runs | processor (s) | longest (s) | MiB | exit 0 | 1 | 2 | 3 | findings |")
        for kind, tally in self.tally.items():
            exits = " | ".join(str(self.counts[f"{kind}: exit {code}"]) for code in (0, 1, 2, 3))
            print(f"| {kind} | {tally['hours']:.2f} | {tally['inputs']} | {tally['runs']} | {tally['seconds']:.0f} | {tally['slowest']:.1f} | "
                  f"{tally['memory']} | {exits} | {tally['findings']} |", flush=True)
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
    parser.add_argument("--kinds", default="case,set,expression,table,mesh,vtu,run,checkpoint")
    parser.add_argument("--limit", type=float, default=60, help="processor seconds after which a run of the program counts as hanging")
    parser.add_argument("--memory", type=int, default=8192, help="MiB of address space of the program")
    parser.add_argument("--resident", type=int, default=300, help="MiB that small files may take")
    parser.add_argument("--keep", default="out/fuzz", help="directory for findings")
    sys.exit(Fuzzer(parser.parse_args()).go())


if __name__ == "__main__":
    main()
