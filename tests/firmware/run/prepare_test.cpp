#include "firmware/run/prepare.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace run_prepare_test {

TEST(Prepare, numbers_that_the_correction_refuses_together_are_an_error_of_the_configuration) {
  const tests::TemporaryFolder folder;
  ConfiguredSpindle configured;
  configured.config = parse_config(
      "network = \"x.rom\"\n[serve]\nport = 1502\n[start]\ntemperature_degC = 20.0\n[signals]\n"
      "speed = { source = \"plc\" }\nload = { source = \"plc\" }\n"
      "coolant = { source = \"plc\" }\nambient = { source = \"plc\" }\n",
      folder.file("twin.toml"));
  configured.config.network.path = folder.file("x.rom");
  rom::write_network(tests::small_network(), configured.config.network.path);
  EXPECT_EQ(prepare(configured)->file.network.spindle, "small");
  configured.config.cycle.estimator->period_s = -1.0;  // no file can say this: its reader refuses it
  EXPECT_EQ(tests::refusal_of([&] {
              prepare(configured);
            }).rfind(folder.file("twin.toml") + ": correction, health: period_s: must be a number", 0),
            0U)
      << tests::refusal_of([&] { prepare(configured); });
}

}  // namespace run_prepare_test
}  // namespace spindle_twin::firmware
