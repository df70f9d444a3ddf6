"""spindle-twin mesh as the spindle engineer meets it: what a mesh errs by, and which sizes make that small.

mesh_choice_test.py SPINDLE_TWIN SPINDLE_TWIND SPINDLES_FOLDER [unittest options]
"""
import unittest

from host_tool_case import REFERENCE, SMALL, Case, run


class Mesh(Case):
    def test_errors_of_a_mesh_and_the_sizes_that_make_them_small(self):
        circuit = REFERENCE.parent / "jacket_circuit.toml"
        described = self.json_of("mesh", circuit)
        worst_um = max(abs(item["error"]) for item in described["errors"] if item["output"] == "deformation")
        found = self.json_of("mesh", circuit, "--for-um", 0.01, "--most-times", 6)
        self.assertTrue(found["reached"])
        first, last = found["meshes"][0], found["meshes"][-1]
        self.assertEqual(first["unknowns"], described["unknowns"])
        self.assertGreater(worst_um / first["error_um"], 0.7)
        self.assertLess(worst_um / first["error_um"], 1.5)
        self.assertLess(max(last["error_um"], last["largest_step_um"]), 0.01)
        text = circuit.read_text()
        corner_mm = found.get("corner_element_size_mm")
        if corner_mm:
            text = text.replace("[mesh]\n", f"[mesh]\ncorner_element_size_mm = {corner_mm:.3g}\n")
        for part, size_mm in found["part_element_size_mm"].items():
            text = text.replace(f'name = "{part}"\n', f'name = "{part}"\nelement_size_mm = {size_mm:.3g}\n', 1)
        written = self.json_of("mesh", self.text("finer.toml", text))
        self.assertEqual(written["unknowns"], last["unknowns"])

    def test_an_error_that_no_mesh_keeps_ends_with_3_and_a_description_without_growth_is_refused(self):
        circuit = REFERENCE.parent / "jacket_circuit.toml"
        self.assertEqual(run("mesh", circuit, "--for-um", 0.001, "--most-times", 1.1).returncode, 3)
        bare = SMALL.read_text().split("[[deformation]]")[0]
        self.assertIn("deformation", self.error_of("mesh", self.text("bare.toml", bare), "--for-um", 0.01))


if __name__ == "__main__":
    unittest.main(verbosity=2)
