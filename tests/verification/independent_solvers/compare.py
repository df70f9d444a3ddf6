#!/usr/bin/env python3
"""Prints our solution, CalculiX's and FreeFEM's side by side; ends with 1 if one is off by more than the limits.

compare.py NAME FOLDER, with the folder as left by `run`.
"""
import json
import math
import sys
from pathlib import Path

LIMIT_K = 0.02
LIMIT_UM = 0.05
LIMIT_HEAT_SHARE = 0.001  # of what a circuit takes, for the heat that its walls give to the liquid
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
                if "minus" in how:
                    state[f"um {output}"] -= state[f"um {how['minus']}"]
    return states


def freefem_figures(folder, start_degC):
    states, timing = {}, {}
    for line in (folder / "results.txt").read_text().split("\n"):
        fields = line.split()
        if len(fields) == 3 and fields[0] == "timing":
            timing[fields[1]] = float(fields[2])
        elif len(fields) >= 4 and fields[1] in ("part", "key_point", "deformation_um", "air", "liquid"):
            state = states.setdefault(fields[0], {})
            values = [float(value) for value in fields[3:]]
            if fields[1] == "part":
                state[f"max {fields[2]}"] = values[0] - start_degC
                state[f"min {fields[2]}"] = values[1] - start_degC
            elif fields[1] == "key_point":
                state[f"point {fields[2]}"] = values[0] - start_degC
            elif fields[1] in ("air", "liquid"):
                state[f"{fields[1]} {fields[2]}"] = {"degC": values[0], "heat_W": values[1]}
            else:
                state[f"um {fields[2]}"] = values[0]
    return states, timing


def heat_from_walls(sides, degC, fluid_degC):
    """What the walls give to a fluid, net and as it passes in either direction, in W, and their conductance in W/K."""
    net_W = through_W = conductance_W_per_K = 0.0
    for a, b, middle, r_a, r_b, length, coefficient in sides:
        # Simpson's rule is exact for radius times the parabola through the three nodes.
        for node, share, radius in ((a, 1, r_a), (middle, 4, 0.5 * (r_a + r_b)), (b, 1, r_b)):
            area_m2 = share / 6 * length * 2 * math.pi * radius
            heat_W = coefficient * area_m2 * (degC[node] - fluid_degC)
            net_W += heat_W
            through_W += abs(heat_W) / 2
            conductance_W_per_K += coefficient * area_m2
    return net_W, through_W, conductance_W_per_K


def air_is_balanced(fluids, degC, freefem):
    """CalculiX has the air's temperature prescribed: its walls must give the air nothing. FreeFEM solves for it."""
    good = True
    for air, data in fluids.items():
        if "circuit" in data:
            continue
        net_W, through_W, conductance_W_per_K = heat_from_walls(data["sides"], degC, data["steady_degC"])
        error_K = net_W / conductance_W_per_K
        solved_K = freefem[f"air {air}"]["degC"] - data["steady_degC"]
        print(f"air {air}: {data['steady_degC']:.4f} degC; FreeFEM solves {solved_K:+.5f} K beside it; CalculiX' walls give it "
              f"{net_W:+.5f} W net of {through_W:.4f} W that pass, {error_K:+.5f} K off balance")
        good = good and abs(error_K) <= LIMIT_K and abs(solved_K) <= LIMIT_K
    return good


def liquid_is_balanced(fluids, degC, freefem, coolant):
    """Flow times heat capacity times the liquid's rise, ours, against the heat that the others' walls give to it.

    CalculiX has the liquid's temperature at the entry of each segment prescribed; FreeFEM solves for it.
    """
    good = True
    for circuit, ours in coolant.items():
        segments = {name: data for name, data in fluids.items() if data.get("circuit") == circuit}
        flow_W_per_K = next(iter(segments.values()))["flow_W_per_K"]
        entries = {data.get("upstream"): data["steady_degC"] for data in segments.values()}
        entries.setdefault(next(name for name in segments if name not in entries), ours["outlet_degC"])
        sums_W = {"ours": 0.0, "CalculiX": 0.0, "FreeFEM": 0.0}
        print(f"circuit {circuit}, {flow_W_per_K:.2f} W/K: heat into the liquid, W, and its temperature at the entry, degC")
        for name, data in segments.items():
            heats_W = {"ours": flow_W_per_K * (entries[name] - data["steady_degC"]),
                       "CalculiX": heat_from_walls(data["sides"], degC, data["steady_degC"])[0],
                       "FreeFEM": freefem[f"liquid {name}"]["heat_W"]}
            solved_K = freefem[f"liquid {name}"]["degC"] - data["steady_degC"]
            sums_W = {solver: sums_W[solver] + heats_W[solver] for solver in sums_W}
            print(f"  {name:24}" + "".join(f"{solver:>10} {heat_W:10.4f}" for solver, heat_W in heats_W.items()) +
                  f"   entry {data['steady_degC']:9.4f}, FreeFEM {solved_K:+.5f}")
            good = good and abs(solved_K) <= LIMIT_K
        shares = {solver: sums_W[solver] / sums_W["ours"] - 1.0 for solver in ("CalculiX", "FreeFEM")}
        print(f"  {'sum':24}" + "".join(f"{solver:>10} {heat_W:10.4f}" for solver, heat_W in sums_W.items()) +
              "   off by " + ", ".join(f"{solver} {share:+.2e}" for solver, share in shares.items()) +
              f" (limit {LIMIT_HEAT_SHARE}); inlet to outlet {sums_W['ours'] / flow_W_per_K:.4f} K")
        good = good and max(map(abs, shares.values())) <= LIMIT_HEAT_SHARE
    return good


def print_table(name, ours, calculix, freefem):
    print(f"\n== {name}: rises in K, deformations in um; differences to ours")
    print(f"{'':8}{'':28}{'ours':>11}{'CalculiX':>11}{'FreeFEM':>11}{'d CalculiX':>12}{'d FreeFEM':>12}")
    worst = {(when, unit): [0.0, 0.0] for when in ("steady state", "first 1800 s") for unit in ("K", "um")}
    for state, figures in ours.items():
        for figure, value in figures.items():
            others = [calculix[state][figure], freefem[state][figure]]
            differences = [other - value for other in others]
            key = ("steady state" if state == "steady" else "first 1800 s", "um" if figure.startswith("um ") else "K")
            worst[key] = [max(seen, abs(new)) for seen, new in zip(worst[key], differences)]
            print(f"{state:8}{figure:28}{value:11.4f}{others[0]:11.4f}{others[1]:11.4f}"
                  f"{differences[0]:12.4f}{differences[1]:12.4f}")
    good = True
    for (when, unit), (of_calculix, of_freefem) in worst.items():
        limit = LIMIT_K if unit == "K" else LIMIT_UM
        good = good and max(of_calculix, of_freefem) <= limit
        print(f"{name}, {when}: largest difference CalculiX {of_calculix:.4f} {unit}, FreeFEM {of_freefem:.4f} {unit} "
              f"(limit {limit})")
    return good


def print_timing(folder, freefem_timing):
    seconds = {run: float((folder / f"{run}.seconds").read_text()) for run in ("1800s", "3600s")}
    our_step_s = (seconds["3600s"] - seconds["1800s"]) / 1800
    steps = sum(step["count"] for step in json.loads((folder / "calculix/outputs.json").read_text())["transient_steps"])
    calculix_step_s = float((folder / "calculix/transient.seconds").read_text()) / steps
    print(f"processor time per transient step: ours {1e3 * our_step_s:.3f} ms, CalculiX {1e3 * calculix_step_s:.3f} ms "
          f"(ratio {calculix_step_s / our_step_s:.1f}), FreeFEM with its factor kept "
          f"{1e3 * freefem_timing['step_s']:.3f} ms (ratio {freefem_timing['step_s'] / our_step_s:.2f})")
    print("ours: two solves per step (order 2); FreeFEM: one (BDF2); CalculiX: backward Euler, factorised every step")


def main():
    name, folder = sys.argv[1], Path(sys.argv[2])
    outputs = json.loads((folder / "calculix/outputs.json").read_text())
    steady = json.loads((folder / "steady.json").read_text())
    freefem, timing = freefem_figures(folder / "freefem", outputs["start_degC"])
    if "growth_left_out" in outputs:
        print(f"\n{name}: growth not compared: {outputs['growth_left_out']}")
    good = print_table(name, our_figures(folder), calculix_figures(folder / "calculix"), freefem)
    degC = {node: value[0] for node, value in read_columns(folder / "calculix/steady_temperatures_1.inc", 1).items()}
    good = air_is_balanced(outputs["fluids"], degC, freefem["steady"]) and good
    good = liquid_is_balanced(outputs["fluids"], degC, freefem["steady"], steady.get("coolant", {})) and good
    print_timing(folder, timing)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
