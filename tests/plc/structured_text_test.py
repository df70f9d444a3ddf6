"""What the checker of the function blocks refuses, and how it counts.

structured_text_test.py [unittest options]
"""
import pathlib
import unittest

import checked_block
import structured_text

PLC = pathlib.Path(__file__).resolve().parents[2] / "host_tools" / "plc"
ST = """FUNCTION_BLOCK Example
VAR_INPUT
  A : UINT := 3;
  W : ARRAY[0..1] OF WORD;
END_VAR
VAR_OUTPUT
  Q : UINT;
  D : DINT;
  B : BOOL;
  R : REAL;
END_VAR
VAR_TEMP
  T : UINT;
END_VAR
VAR CONSTANT
  PLACE : INT := 1;
END_VAR
T := A + WORD_TO_UINT(W[PLACE]);
{}
Q := T;
END_FUNCTION_BLOCK
"""


def example(statements, dialect=structured_text.ST, text=ST):
    return checked_block.checked(structured_text.read_blocks(text.format(statements), dialect)[0])


class Checker(unittest.TestCase):
    def refused(self, statements, words):
        with self.assertRaises((structured_text.SyntaxProblem, checked_block.TypeProblem)) as caught:
            example(statements)
        self.assertRegex(str(caught.exception), words)
        self.assertRegex(str(caught.exception), "line (19|20|21)")  # the line itself, or the words behind it

    def test_the_example_itself_is_good(self):
        block = example("")
        values = block.initial_values()
        values["W"] = [0, 4]
        block.step(values)
        self.assertEqual(values["Q"], 7)

    def test_what_is_no_sentence_is_refused(self):
        for statements in ("B := TRUE", "IF B THEN B := FALSE;", "IF B B := TRUE; END_IF;", "B = TRUE;", "B := (TRUE;",
                           "B := 1 == 2;", "B := TRUE AND;", "(* open", "(* a (* b *)", "B := 'x';", "D := 1.;", "FOR B;", "@"):
            self.refused(statements, "expected|begins nothing|comment|STRING where")

    def test_what_does_not_fit_together_is_refused(self):
        for statements, words in (("D := T;", "UINT where DINT"), ("B := T;", "UINT where BOOL"), ("Q := 65536;", "does not fit UINT"),
                                  ("D := 1.5;", "where DINT"), ("R := 1;", "where REAL"), ("R := R + D;", "DINT where REAL"),
                                  ("B := W[0];", "WORD where BOOL"), ("Q := WORD_TO_UINT(T);", "UINT where WORD"),
                                  ("Q := UINT_TO_WORD(T);", "function"), ("B := T AND 1;", "AND between UINT"),
                                  ("Q := -T;", "- before UINT"), ("B := NOT T;", "NOT before"), ("R := R MOD R;", "MOD between"),
                                  ("B := TRUE > FALSE;", "> between"), ("IF T THEN B := TRUE; END_IF;", "UINT where BOOL")):
            self.refused(statements, words)

    def test_names_are_as_declared(self):
        for statements, words in (("Missing := 1;", "Missing"), ("b := TRUE;", "b is not declared"), ("A := 1;", "VAR_INPUT"),
                                  ("PLACE := 1;", "CONSTANT"), ("#B := TRUE;", "#"), ("Q := WORD_TO_UINT(W[2]);", "0 to 1"),
                                  ("Q := WORD_TO_UINT(W[T]);", "constant"), ("B := A[0] = 1;", "array"), ("T(A := 1);", "cannot be called")):
            self.refused(statements, words)

    def test_a_temporary_variable_is_written_before_it_is_read(self):
        text = ST.replace("T := A + WORD_TO_UINT(W[PLACE]);", "B := WORD_TO_UINT(W[PLACE]) = A;")
        good = ("T := 1;", "IF B THEN T := 1; ELSE T := 2; END_IF;", "IF B THEN T := 1; ELSE RETURN; END_IF;")
        bad = ("", "IF B THEN T := 1; END_IF;", "IF B THEN T := 1; ELSIF NOT B THEN T := 2; END_IF;", "T := T;")
        for statements in good:
            example(statements, text=text)
        for statements in bad:
            with self.assertRaisesRegex(checked_block.TypeProblem, "not always written"):
                example(statements, text=text)

    def test_nothing_is_declared_twice_or_in_vain(self):
        with self.assertRaisesRegex(structured_text.SyntaxProblem, "declared twice"):
            example("", text=ST.replace("T : UINT;", "T : UINT; q : UINT;"))
        with self.assertRaisesRegex(checked_block.TypeProblem, "nobody reads Spare"):
            example("", text=ST.replace("T : UINT;", "T : UINT; Spare : UINT;"))

    def test_a_number_that_does_not_fit_is_an_error_not_another_number(self):
        for statements in ("Q := T - 8;", "Q := T * 65535;", "D := UDINT_TO_DINT(3000000000);"):
            block = example(statements)
            with self.assertRaises(OverflowError):
                block.step(block.initial_values())

    def test_it_counts_as_controls_do(self):
        for statements, name, value in (("D := -7; D := D / 2;", "D", -3), ("D := -7; D := D MOD 2;", "D", -1),
                                        ("R := 2.5; D := REAL_TO_DINT(R);", "D", 2), ("R := -2.6; D := REAL_TO_DINT(R);", "D", -3),
                                        ("R := 16777216.0; R := R + 1.0;", "R", 16777216.0),
                                        ("D := INT_TO_DINT(WORD_TO_INT(16#FFFF));", "D", -1),
                                        ("B := 2 + T * 4 = 14;", "B", True), ("B := TRUE OR TRUE AND FALSE;", "B", True)):
            block = example(statements)
            values = block.initial_values()
            block.step(values)
            self.assertEqual(values[name], value, statements)

    def test_scl_wants_the_number_sign(self):
        text = (PLC / "spindle_twin.scl").read_text(encoding="utf-8")
        for wrong in (text.replace("#Valid := FALSE", "Valid := FALSE", 1), text.replace("BEGIN", "", 1),
                      text.replace('"SpindleTwin"', "SpindleTwin", 1), text.replace("VERSION : 0.1", "", 1)):
            with self.assertRaises(structured_text.SyntaxProblem):
                structured_text.read_blocks(wrong, structured_text.SCL)


if __name__ == "__main__":
    unittest.main()
