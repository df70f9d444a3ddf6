"""A fault that is turned on by a switch is the fault itself, and with all switches off nothing has changed."""
import os
import pathlib
import subprocess
import tempfile
import unittest

import faults
import switches

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOY = """#include <algorithm>
#include <cstdio>

constexpr double gain = 2.5;
static double twice(double value) { return value * 2.0; }
struct Counter {
  int count = 0;
  bool open = true;
};

int main() {
  Counter counter;
  double sum = 0.0;
  for (int i = 0; i < 5; ++i) {
    sum += gain * i - 1.0;
    if (i > 2 && counter.open) counter.count += 3;
    if (i == 4 || sum >= 100.0) counter.open = false;
  }
  const int last = std::max(counter.count, 4);
  // 7 in a comment and in "a text of 7" is no token.
  std::printf("%s 7 %.6g %.6g %d %d\\n", "a text of 7", twice(sum) + gain, sum / 3.0, last, counter.open ? 1 : 0);
  return counter.count <= 6 ? 0 : 1;
}
"""


class Switches(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.tree = pathlib.Path(self.folder.name)
        (self.tree / "toy").mkdir()
        (self.tree / "toy" / "toy.cpp").write_text(TOY)
        self.drawn = faults.draw(self.tree, "toy", 1)

    def tearDown(self):
        self.folder.cleanup()

    def compile(self, text, name):
        source = self.tree / f"{name}.cpp"
        source.write_text(text)
        subprocess.run(["c++", "-std=c++20", "-w", f"-I{ROOT}", str(source), "-o", str(self.tree / name)], check=True)
        return self.tree / name

    def each_alone(self):
        """A program of the toy with each fault in turn, by its number, and last without any."""
        bodies = []
        for fault in [*self.drawn, None]:
            lines = TOY.split("\n")
            if fault is not None:
                _, line, column, token = fault
                lines[line] = lines[line][:column] + faults.other(token) + lines[line][column + len(token):]
            bodies.append("\n".join(line for line in lines if not line.startswith("#")).replace("int main()", "int toy()"))
        program = "#include <algorithm>\n#include <cstdio>\n#include <cstdlib>\n"
        program += "".join(f"namespace fault_{number} {{\n{body}\n}}\n" for number, body in enumerate(bodies))
        calls = ", ".join(f"fault_{number}::toy" for number in range(len(bodies)))
        program += f"int main(int, char** words) {{ int (*all[])() = {{{calls}}}; return all[std::atoi(words[1])](); }}\n"
        return self.compile(program, "alone")

    def said(self, program, *words, fault=None, reached=None):
        environment = dict(os.environ)
        if fault is not None:
            environment["SPINDLE_TWIN_FAULT"] = str(fault)
        if reached is not None:
            environment["SPINDLE_TWIN_REACHED"] = str(reached)
        done = subprocess.run([program, *map(str, words)], env=environment, capture_output=True, text=True, check=False, timeout=10)
        return done.returncode, done.stdout

    def switched(self):
        """The program with all switches, and the numbers of its faults."""
        of_file = [(number, *fault[1:], switches.MUST) for number, fault in enumerate(self.drawn)]
        text, written = switches.with_switches(TOY, of_file, False)
        program = self.compile(text, "switched")
        return program, written

    def test_each_switch_is_its_fault_and_all_off_are_none(self):
        program, written = self.switched()
        alone = self.each_alone()
        whole = self.said(program)
        self.assertEqual(whole, self.said(alone, len(self.drawn)))
        for number in sorted(written):
            self.assertEqual(self.said(program, fault=number), self.said(alone, number), f"{self.drawn[number]}, seed 1")
        changed = sum(self.said(program, fault=number) != whole for number in written)
        self.assertGreater(changed, 15)
        self.assertGreaterEqual(len(written), len(self.drawn) - 2, "only what stands in another fault's expression is left")

    def test_a_program_lists_all_switches_and_notes_those_that_it_passes(self):
        program, written = self.switched()
        reached = self.tree / "reached"
        self.said(program, reached=reached)
        passed = {number for number, byte in enumerate(reached.read_bytes()) if byte}
        self.assertEqual(switches.asked_when_running(program), written)
        never = written - passed  # the choices that are not taken
        self.assertEqual(sorted(self.drawn[number][3] for number in never), ["1", "1"])

    def test_comments_and_texts_hold_no_fault(self):
        line = TOY.split("\n").index('  // 7 in a comment and in "a text of 7" is no token.')
        self.assertFalse([fault for fault in self.drawn if fault[1] == line])

    def test_an_error_is_laid_to_its_line(self):
        log = f"FAILED: toy.o\n{self.tree}/toy/toy.cpp:4:2:   required from here\n{self.tree}/toy/toy.hpp:9:1: error: no\n"
        self.assertEqual(switches.lines_to_blame(log, self.tree), [[("toy/toy.hpp", 8), ("toy/toy.cpp", 3)]])


if __name__ == "__main__":
    unittest.main()
