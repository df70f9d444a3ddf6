"""The VTU fields, read back by a library of its own and held against closed forms and the command's own numbers.

field_file_test.py SPINDLE_TWIN SPINDLE_TWIND SPINDLES_FOLDER [unittest options]
"""
import pathlib
import unittest

import meshio
import numpy as np

from host_tool_case import SPINDLES, Case

CASES = pathlib.Path(SPINDLES).parent / "verify_cases"


class FieldFile(Case):
    def solve(self, path):
        """The file's points (r, z; m), its fields, and what the command said."""
        said = self.json_of("solve", path, "--vtu", self.folder)
        self.mesh = meshio.read(self.folder / f"{path.stem}.vtu")
        return self.mesh.points[:, 0], self.mesh.points[:, 1], self.mesh.point_data, said

    def test_temperature_and_flux_of_two_rings_are_those_of_the_closed_form(self):
        r, z, fields, said = self.solve(CASES / "two_rings.toml")
        inside = fields["part"] == 0
        flux = 1e4 * 0.020 / r  # what enters at the bore passes every radius
        surface = 20 + 1e4 * 0.020 / 0.060 / 100
        exact = np.where(inside, surface + 200 / 15 * np.log(0.060 / 0.035) + 200 / 0.035 / 2000 +
                         200 / 50 * np.log(0.035 / r), surface + 200 / 15 * np.log(0.060 / r))
        self.assertLess(np.abs(fields["temperature_degC"] - exact).max(), 1e-4 * 45)
        self.assertLess(np.abs(fields["rise_K"] - (exact - 20)).max(), 1e-4 * 45)
        self.assertLess(np.abs(fields["heat_flux_W_per_m2"][:, 0] / flux - 1).max(), 0.01)
        self.assertLess(np.abs(fields["heat_flux_W_per_m2"][:, 1]).max(), 1e-6 * 1e4)
        # The contact is a step between two nodes at one place.
        at = {part: fields["temperature_degC"][(np.abs(r - 0.035) < 1e-9) & (inside == part)] for part in (True, False)}
        self.assertAlmostEqual(at[True].mean() - at[False].mean(), 200 / 0.035 / 2000, delta=1e-3)
        bore = fields["rise_K"][(np.abs(r - 0.020) < 1e-9) & (np.abs(z - 0.005) < 1e-9)]
        self.assertAlmostEqual(bore.mean(), said["rise_K"]["key_points"][0], delta=1e-4)

    def test_elements_cover_the_section_and_name_their_parts(self):
        self.solve(CASES / "two_rings.toml")
        areas = {0: 0.0, 1: 0.0}
        for block in self.mesh.cells:
            corners = self.mesh.points[block.data]
            parts = self.mesh.point_data["part"][block.data]
            self.assertTrue((parts == parts[:, :1]).all(), "an element with points of two parts")
            diagonal, other = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
            area = 0.5 * np.abs(diagonal[:, 0] * other[:, 1] - diagonal[:, 1] * other[:, 0])
            for part in areas:
                areas[part] += area[parts[:, 0] == part].sum()
        self.assertAlmostEqual(areas[0], 0.015 * 0.010, delta=1e-9)
        self.assertAlmostEqual(areas[1], 0.025 * 0.010, delta=1e-9)

    def test_stress_and_displacement_of_the_hollow_cylinder_are_those_of_the_closed_form(self):
        r, z, fields, said = self.solve(CASES / "hollow_cylinder.toml")
        a, b, young, poisson, expansion, rise = 0.020, 0.040, 219e9, 0.3, 1.2e-5, 10.0
        scale = young * expansion * rise / (2 * (1 - poisson) * np.log(b / a))
        ring = a**2 / (b**2 - a**2) * np.log(b / a)
        exact = {"rr": scale * (-np.log(b / r) - ring * (1 - b**2 / r**2)),
                 "tt": scale * (1 - np.log(b / r) - ring * (1 + b**2 / r**2)),
                 "zz": scale * (1 - 2 * np.log(b / r) - 2 * ring), "rz": 0 * r}
        for name, stress_Pa in exact.items():
            error = np.abs(fields[f"stress_{name}_Pa"] - stress_Pa).max()
            self.assertLess(error, 0.01 * 23e6, name)
        components = {name: fields[f"stress_{name}_Pa"].astype(float) for name in exact}
        mises = np.sqrt(0.5 * ((components["rr"] - components["zz"])**2 + (components["zz"] - components["tt"])**2 +
                               (components["tt"] - components["rr"])**2) + 3 * components["rz"]**2)
        self.assertLess(np.abs(fields["stress_von_mises_Pa"] - mises).max(), 1e-5 * mises.max())
        u_r = 1e6 * fields["displacement_m"][:, 0]
        self.assertLess(np.abs(u_r[np.abs(r - a) < 1e-9] - 0.931234).max(), 1e-3)
        self.assertLess(np.abs(u_r[np.abs(r - b) < 1e-9] - 1.8624681).max(), 1e-3)
        self.assertLess(np.abs(fields["displacement_m"][z == 0, 1]).max(), 1e-15)
        probe = (np.abs(r - a) < 1e-9) & (np.abs(z - 0.010) < 1e-9)
        for name, stress_MPa in said["stress_MPa"]["at_bore"].items():
            self.assertAlmostEqual(1e-6 * fields[f"stress_{name}_Pa"][probe].mean(), stress_MPa, delta=0.02, msg=name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
