#!/usr/bin/env python3
"""Prints our solution, CalculiX's and FreeFEM's side by side; ends with 1 if one is off by more than the limits.

compare.py NAME FOLDER, with the folder as left by `run`.
"""
import json
import sys
from pathlib import Path

LIMIT_K = 0.02
LIMIT_UM = 0.05
TIMES_S = [60, 300, 900, 1800]


def read_columns(path, columns):
    """Node number to values, from lines that hold a node number and `columns` numbers."""
    found = {}
    for line in path.read_text().replace(",", " ").split("\n"):
        fields = line.split()
        if len(fields) == columns + 1 and fields[0].isdigit():
            found[int(fields[0])] = [float(field) for field in fields[1:]]
    return found


def our_figures(folder):
    """State to {figure: value}; rises above the start in K, deformations in um."""
    steady = json.loads((folder / "steady.json").read_text())
    outputs = json.loads((folder / "calculix/outputs.json").read_text())
    points, carried = outputs["key_points"], outputs["deformations"]
    states = {"steady": {}}
    for part, rise_K in steady["rise_K"]["max"].items():
        states["steady"][f"max {part}"] = rise_K
        states["steady"][f"min {part}"] = steady["rise_K"]["min"][part]
    for point, rise_K in zip(points, steady["rise_K"]["key_points"]):
        states["steady"][f"point {point}"] = rise_K
    for output, moved_um in steady["deformation_um"].items():
        if output in carried:
            states["steady"][f"um {output}"] = moved_um
    series = json.loads((folder / "transient.json").read_text())["series"]
    for time_s in TIMES_S:
        row = min(range(len(series["time_s"])), key=lambda i: abs(series["time_s"][i] - time_s))
        state = states[f"{time_s}s"] = {}
        for part, rises_K in series["part_max_K"].items():
            state[f"max {part}"] = rises_K[row]
        for index, point in enumerate(points):
            state[f"point {point}"] = series["key_points_K"][row][index]
        for output, moved_um in series.get("deformation_um", {}).items():
            if output in carried:
                state[f"um {output}"] = moved_um[row]
    return states


def calculix_figures(folder):
    outputs = json.loads((folder / "outputs.json").read_text())
    files = {"steady": "steady_temperatures_1.inc"}
    files.update({f"{time_s}s": f"transient_temperatures_{i + 1}.inc" for i, time_s in enumerate(TIMES_S)})
    states = {}
    for name, file in files.items():
        rises_K = {node: value[0] - outputs["start_degC"] for node, value in read_columns(folder / file, 1).items()}
        state = states[name] = {}
        for part, nodes in outputs["parts"].items():
            state[f"max {part}"] = max(rises_K[node] for node in nodes)
            state[f"min {part}"] = min(rises_K[node] for node in nodes)
        for point, row in outputs["key_points"].items():
            state[f"point {point}"] = sum(weight * rises_K[node] for node, weight in row)
        if outputs["deformations"]:
            moved_m = read_columns(folder / f"growth_{name}.dat", 3)
            for output, how in outputs["deformations"].items():
                axis = how["direction"] - 1
                state[f"um {output}"] = 1e6 * sum(weight * moved_m[node][axis] for node, weight in how["nodes"])
    return states


def freefem_figures(folder, start_degC):
    states, timing = {}, {}
    for line in (folder / "results.txt").read_text().split("\n"):
        fields = line.split()
        if len(fields) == 3 and fields[0] == "timing":
            timing[fields[1]] = float(fields[2])
        elif len(fields) >= 4 and fields[1] in ("part", "key_point", "deformation_um", "air"):
            state = states.setdefault(fields[0], {})
            values = [float(value) for value in fields[3:]]
            if fields[1] == "part":
                state[f"max {fields[2]}"] = values[0] - start_degC
                state[f"min {fields[2]}"] = values[1] - start_degC
            elif fields[1] == "key_point":
                state[f"point {fields[2]}"] = values[0] - start_degC
            elif fields[1] == "air":
                state[f"air {fields[2]}"] = values[0] - start_degC
            else:
                state[f"um {fields[2]}"] = values[0]
    return states, timing


def air_balances(folder):
    """CalculiX has the air's temperature prescribed; the heat that its solution then gives to the air, and through it."""
    outputs = json.loads((folder / "outputs.json").read_text())
    degC = {node: value[0] for node, value in read_columns(folder / "steady_temperatures_1.inc", 1).items()}
    for air, data in outputs["air"].items():
        net_W = through_W = conductance_W_per_K = 0.0
        for a, b, middle, r_a, r_b, length, coefficient in data["sides"]:
            # Simpson's rule is exact for radius times the parabola through the three nodes.
            for node, share, radius in ((a, 1, r_a), (middle, 4, 0.5 * (r_a + r_b)), (b, 1, r_b)):
                area_m2 = share / 6 * length * 2 * 3.141592653589793 * radius
                heat_W = coefficient * area_m2 * (degC[node] - data["steady_degC"])
                net_W += heat_W
                through_W += abs(heat_W) / 2
                conductance_W_per_K += coefficient * area_m2
        yield air, net_W, through_W, net_W / conductance_W_per_K


def print_table(name, ours, calculix, freefem):
    print(f"\n== {name}: rises in K, deformations in um; differences to ours")
    print(f"{'':8}{'':28}{'ours':>11}{'CalculiX':>11}{'FreeFEM':>11}{'d CalculiX':>12}{'d FreeFEM':>12}")
    worst = {"K": [0.0, 0.0], "um": [0.0, 0.0]}
    for state, figures in ours.items():
        for figure, value in figures.items():
            others = [calculix[state][figure], freefem[state][figure]]
            differences = [other - value for other in others]
            unit = "um" if figure.startswith("um ") else "K"
            worst[unit] = [max(seen, abs(new)) for seen, new in zip(worst[unit], differences)]
            print(f"{state:8}{figure:28}{value:11.4f}{others[0]:11.4f}{others[1]:11.4f}"
                  f"{differences[0]:12.4f}{differences[1]:12.4f}")
    print(f"{name}: largest difference  K: CalculiX {worst['K'][0]:.4f}, FreeFEM {worst['K'][1]:.4f} (limit {LIMIT_K});"
          f"  um: CalculiX {worst['um'][0]:.4f}, FreeFEM {worst['um'][1]:.4f} (limit {LIMIT_UM})")
    return max(worst["K"]) <= LIMIT_K and max(worst["um"]) <= LIMIT_UM


def print_timing(folder, freefem_timing):
    seconds = {run: float((folder / f"{run}.seconds").read_text()) for run in ("1800s", "5400s")}
    our_step_s = (seconds["5400s"] - seconds["1800s"]) / 3600
    steps = sum(step["count"] for step in json.loads((folder / "calculix/outputs.json").read_text())["transient_steps"])
    calculix_step_s = float((folder / "calculix/transient.seconds").read_text()) / steps
    print(f"processor time per transient step: ours {1e3 * our_step_s:.3f} ms, CalculiX {1e3 * calculix_step_s:.3f} ms "
          f"(ratio {calculix_step_s / our_step_s:.1f}), FreeFEM with its factor kept "
          f"{1e3 * freefem_timing['step_s']:.3f} ms (ratio {freefem_timing['step_s'] / our_step_s:.2f})")
    print("ours: two solves per step (order 2); FreeFEM: one (BDF2); CalculiX: backward Euler, factorised every step")


def main():
    name, folder = sys.argv[1], Path(sys.argv[2])
    start_degC = json.loads((folder / "calculix/outputs.json").read_text())["start_degC"]
    freefem, timing = freefem_figures(folder / "freefem", start_degC)
    left_out = json.loads((folder / "calculix/outputs.json").read_text()).get("growth_left_out")
    if left_out:
        print(f"\n{name}: growth not compared: {left_out}")
    good = print_table(name, our_figures(folder), calculix_figures(folder / "calculix"), freefem)
    for air, net_W, through_W, error_K in air_balances(folder / "calculix"):
        free_K = freefem["steady"][f"air {air}"]
        print(f"air {air}: FreeFEM solves {free_K:.4f} K; prescribed in CalculiX, whose walls then give it {net_W:+.5f} W "
              f"net of {through_W:.4f} W that pass, {error_K:+.5f} K off balance")
        good = good and abs(error_K) <= LIMIT_K
    print_timing(folder, timing)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
