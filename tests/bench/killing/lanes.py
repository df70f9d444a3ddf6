"""What the three programs have in common: their options, and trials that several lanes work off side by side. A lane is a
daemon with a folder of its own."""
import argparse
import collections
import pathlib
import threading
import traceback

import seam

MOST_FAILURES = 20  # then nothing more is tried


def options_of(doc, **numbers):
    """The options of the command line and the programs by name; each of `numbers` is an option with its default."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs=3, type=pathlib.Path)
    for name, default in {**numbers, "seed": 1}.items():
        parser.add_argument(f"--{name}", type=int, default=default)
    options = parser.parse_args()
    daemon, make_network, seam.Seam.library = [path.resolve() for path in options.programs]
    print(f"seed {options.seed}", flush=True)
    return options, {"daemon": daemon, "make_network": make_network}


def run_side_by_side(lanes, work):
    """work(lane) of each lane in a thread of its own, until all have ended."""
    threads = [threading.Thread(target=work, args=(lane,)) for lane in lanes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def work_off(lanes, trials, totals):
    """Makes the trials (kind, number of the call, what lane.trial() is given), counts them by kind, and gives the text of
    each that failed."""
    waiting, failures = collections.deque(trials), []

    def work(lane):
        while len(failures) < MOST_FAILURES:
            try:
                kind, number, given = waiting.popleft()
            except IndexError:
                return
            try:
                lane.trial(*given)
                totals[f"{lane.history}: {kind}"] += 1
            except Exception:  # told by the main thread
                failures.append(f"{lane.history}, {kind}, call {number}: {traceback.format_exc()}{lane.told()}")
                if lane.twin.daemon:
                    lane.twin.end()

    run_side_by_side(lanes, work)
    return failures
