"""All that is tested of the loop through LinuxCNC. Run by ./run: loop_test.py ROOT WORK [unittest options]"""
import pathlib
import sys
import unittest

import fault_scenarios
import growth_scenarios


class Faults(fault_scenarios.Scenarios):
    pass


class Growth(growth_scenarios.Scenarios):
    pass


def main():
    for scenarios in (Faults, Growth):
        scenarios.root, scenarios.work = sys.argv[1], pathlib.Path(sys.argv[2])
    outcome = unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2, exit=False).result
    sys.exit(0 if outcome.testsRun and outcome.wasSuccessful() else 1)


if __name__ == "__main__":
    main()
