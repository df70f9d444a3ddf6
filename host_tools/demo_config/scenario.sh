# The paper's experiment, sourced by host_tools/demo: what the simulated spindle is, and what the twin is not told.
# shellcheck shell=bash disable=SC2034
rate=60          # model seconds per second, as in twin.toml
duration_s=1800  # model time
plant_truth=(
  --heat-factor all=0.46                          # the description's heats are 2.2 times too high
  --contact-spread 2:2.0                          # every joint off by up to 2x either way, seed 2
  --noise-K 0.03 --seed 2
  --offset-K inner=0.02 --offset-K outer=-0.02)

# write_twin_config FOLDER PLANT_PORT TWIN_PORT: twin.toml for this run, beside reference.rom in FOLDER.
write_twin_config() {
  sed -e "s/15020/$2/" -e "s/15021/$3/" host_tools/demo_config/twin.toml >"$1/twin.toml"
}
