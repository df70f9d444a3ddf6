# The paper's experiment, sourced by host_tools/demo: what the simulated spindle is, and what the twin is not told.
# shellcheck shell=bash disable=SC2034
rate=60          # model seconds per second, as in twin.toml
duration_s=1800  # model time
plant_truth=(
  --heat-factor all=0.46                          # the description's heats are 2.2 times too high
  --contact-spread 2:2.0                          # every joint off by up to 2x either way, seed 2
  --noise-K 0.03 --seed 2
  --offset-K inner=0.02 --offset-K outer=-0.02)
