#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include "host_tools/fmu/write_fmu.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "tests/exports/importer.hpp"
#include "tests/rom/synthetic_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools::tests {
namespace fmu_test {

/// Another speed, load and temperatures every 10 s; a smooth drift in between.
rom::OperatingState state_at(const rom::Boundaries& boundaries, int second) {
  rom::OperatingState state = boundaries.operating;
  state.speed_rpm = 3000.0 * (1 + (second / 10) % 4);
  state.load = 0.25 * ((second / 10) % 5);
  state.environment_K.array() += 0.01 * second;
  return state;
}

/// Written once for all tests: packing the library takes longer than the rest of them.
struct Exported {
  rom::Network network = rom::tests::make_synthetic_network({}, 7);
  spindle_twin::tests::TemporaryFolder folder;
  std::string path = folder.file("x.fmu");
  Exported() { write_fmu(network, rom::encode_network(network), path); }
};
const Exported& exported() {
  static const Exported once;
  return once;
}

class Fmu : public ::testing::Test {
 protected:
  void SetUp() override { importer_ = std::make_unique<Importer>(path_); }

  void begin(fmi2Component slave) {
    ASSERT_EQ(FMI2_CALL(*importer_, fmi2SetupExperiment)(slave, 0, 0.0, 0.0, 0, 0.0), fmi2OK);
    ASSERT_EQ(FMI2_CALL(*importer_, fmi2EnterInitializationMode)(slave), fmi2OK);
    ASSERT_EQ(FMI2_CALL(*importer_, fmi2ExitInitializationMode)(slave), fmi2OK);
  }
  void give(fmi2Component slave, const rom::OperatingState& state) {
    importer_->set(slave, "speed", state.speed_rpm);
    importer_->set(slave, "load", state.load);
    for (std::size_t e = 0; e < network_.boundaries.environments.size(); ++e) {
      ASSERT_EQ(importer_->set(slave, "environment." + network_.boundaries.environments[e].name,
                               state.environment_K[static_cast<Eigen::Index>(e)]),
                fmi2OK);
    }
  }
  fmi2Status step(fmi2Component slave, int second) {
    give(slave, state_at(network_.boundaries, second));
    return FMI2_CALL(*importer_, fmi2DoStep)(slave, second, 1.0, 1);
  }
  double nose_m(fmi2Component slave) { return importer_->get(slave, "deformation." + network_.deformations[0].name); }

  const rom::Network& network_ = exported().network;
  const std::string& path_ = exported().path;
  std::unique_ptr<Importer> importer_;
};

TEST_F(Fmu, gives_the_runtimes_own_numbers_bit_for_bit) {
  fmi2Component slave = importer_->instantiate("spindle");
  ASSERT_NE(slave, nullptr) << (importer_->messages.empty() ? "" : importer_->messages[0]);
  begin(slave);
  const auto stepper = rom::make_runtime_stepper(network_);
  rom::NetworkOutputs outputs = rom::make_network_outputs(network_);
  rom::BoundaryValues values = rom::make_boundary_values(network_.boundaries);
  const double rest_K = rom::rest_temperature_K(network_.boundaries, network_.boundaries.operating);
  stepper->set_temperatures(Eigen::VectorXd::Constant(network_.capacity_J_per_K.rows(), rest_K));
  for (int second = 0; second < 120; ++second) {
    ASSERT_EQ(step(slave, second), fmi2OK) << importer_->messages.back();
    rom::evaluate_boundaries(network_.boundaries, state_at(network_.boundaries, second),
                             rom::no_correction(network_.boundaries), values);
    ASSERT_EQ(stepper->advance(1.0, values), rom::StepStatus::ok);
    rom::evaluate_outputs(network_, stepper->temperatures_K(), outputs);
    ASSERT_EQ(nose_m(slave), outputs.deformations_m[0]) << "after " << second + 1 << " s";
    for (std::size_t k = 0; k < network_.key_points.size(); ++k) {
      ASSERT_EQ(importer_->get(slave, "temperature." + network_.key_points[k].name),
                outputs.key_points_K[static_cast<Eigen::Index>(k)]);
    }
    for (std::size_t p = 0; p < network_.parts.size(); ++p) {
      ASSERT_EQ(importer_->get(slave, "maximum_temperature." + network_.parts[p].name),
                outputs.part_maximum_K[static_cast<Eigen::Index>(p)]);
      ASSERT_EQ(importer_->get(slave, "mean_temperature." + network_.parts[p].name),
                outputs.part_mean_K[static_cast<Eigen::Index>(p)]);
    }
  }
  EXPECT_GT(std::abs(outputs.deformations_m[0]), 0.0);
  FMI2_CALL(*importer_, fmi2FreeInstance)(slave);
}

TEST(FmuWithCircuit, outlet_and_heat_are_the_runtimes_own_while_the_flow_stops_and_turns) {
  const rom::Network network = rom::tests::make_network_with_circuit({}, 9);
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string path = folder.file("x.fmu");
  write_fmu(network, rom::encode_network(network), path);
  {
    Importer importer(path);
    fmi2Component slave = importer.instantiate("spindle");
    ASSERT_NE(slave, nullptr);
    ASSERT_EQ(importer.starts.at("flow.helix"), 0.03);
    ASSERT_EQ(FMI2_CALL(importer, fmi2SetupExperiment)(slave, 0, 0.0, 0.0, 0, 0.0), fmi2OK);
    ASSERT_EQ(FMI2_CALL(importer, fmi2EnterInitializationMode)(slave), fmi2OK);
    ASSERT_EQ(FMI2_CALL(importer, fmi2ExitInitializationMode)(slave), fmi2OK);
    const auto coordinates = std::make_shared<const rom::NetworkOperator>(network);
    const auto stepper = rom::make_runtime_stepper(network);
    rom::BoundaryValues values = rom::make_boundary_values(network.boundaries);
    rom::OperatingState state = network.boundaries.operating;
    stepper->set_temperatures(
        Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), rom::rest_temperature_K(network.boundaries, state)));
    constexpr std::array<double, 3> flows_kg_per_s{0.03, 0.0, -0.02};
    double most_heat_W = 0.0;
    for (int second = 0; second < 90; ++second) {
      state.flow_kg_per_s[0] = flows_kg_per_s[static_cast<std::size_t>(second / 30)];
      ASSERT_EQ(importer.set(slave, "flow.helix", state.flow_kg_per_s[0]), fmi2OK);
      ASSERT_EQ(FMI2_CALL(importer, fmi2DoStep)(slave, second, 1.0, 1), fmi2OK);
      rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
      ASSERT_EQ(stepper->advance(1.0, values), rom::StepStatus::ok);
      const rom::CoolantOutlets coolant = rom::coolant_outlets(*coordinates, values, stepper->temperatures_K());
      ASSERT_EQ(importer.get(slave, "coolant_outlet.helix"), coolant.outlet_K[0]) << "after " << second + 1 << " s";
      ASSERT_EQ(importer.get(slave, "coolant_heat.helix"), coolant.heat_W[0]) << "after " << second + 1 << " s";
      most_heat_W = std::max(most_heat_W, coolant.heat_W.cwiseAbs().maxCoeff());
    }
    EXPECT_GT(most_heat_W, 0.0);
    FMI2_CALL(importer, fmi2FreeInstance)(slave);
  }
}

TEST(FmuWithMeasuredHeat, the_watts_are_an_input_that_starts_at_their_nominal_value) {
  const rom::Network network = rom::read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/two_node.toml");
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string path = folder.file("x.fmu");
  write_fmu(network, rom::encode_network(network), path);
  Importer importer(path);
  fmi2Component slave = importer.instantiate("motor");
  ASSERT_NE(slave, nullptr);
  EXPECT_EQ(importer.starts.at("measured_heat.loss"), 150.0);
  EXPECT_EQ(importer.units.at("measured_heat.loss"), "W");
  ASSERT_EQ(FMI2_CALL(importer, fmi2SetupExperiment)(slave, 0, 0.0, 0.0, 0, 0.0), fmi2OK);
  ASSERT_EQ(FMI2_CALL(importer, fmi2EnterInitializationMode)(slave), fmi2OK);
  ASSERT_EQ(FMI2_CALL(importer, fmi2ExitInitializationMode)(slave), fmi2OK);
  ASSERT_EQ(importer.set(slave, "measured_heat.loss", 60.0), fmi2OK);
  for (int hour = 0; hour < 20; ++hour) {
    ASSERT_EQ(FMI2_CALL(importer, fmi2DoStep)(slave, 3600.0 * hour, 3600.0, 1), fmi2OK);
  }
  EXPECT_EQ(importer.get(slave, "heat.loss"), 60.0);
  EXPECT_NEAR(importer.get(slave, "temperature.housing"), 293.15 + 60.0 / 5.0, 1e-2);
  FMI2_CALL(importer, fmi2FreeInstance)(slave);
}

TEST_F(Fmu, two_slaves_at_once_do_not_share_anything) {
  fmi2Component one = importer_->instantiate("one");
  fmi2Component other = importer_->instantiate("other");
  begin(one);
  begin(other);
  for (int second = 0; second < 20; ++second) ASSERT_EQ(step(one, second), fmi2OK);
  const double nose_of_one_m = nose_m(one);
  EXPECT_NE(nose_m(other), nose_of_one_m);
  for (int second = 0; second < 20; ++second) ASSERT_EQ(step(other, second), fmi2OK);
  EXPECT_EQ(nose_m(other), nose_of_one_m);
  FMI2_CALL(*importer_, fmi2FreeInstance)(one);
  ASSERT_EQ(step(other, 20), fmi2OK);
  FMI2_CALL(*importer_, fmi2FreeInstance)(other);
}

TEST_F(Fmu, reset_begins_the_same_run_again) {
  fmi2Component slave = importer_->instantiate("spindle");
  begin(slave);
  importer_->set(slave, "conductance_factor." + network_.boundaries.conductances[0].name, 3.0);
  for (int second = 0; second < 30; ++second) ASSERT_EQ(step(slave, second), fmi2OK);
  const double with_factor_m = nose_m(slave);
  ASSERT_EQ(FMI2_CALL(*importer_, fmi2Reset)(slave), fmi2OK);
  begin(slave);
  for (int second = 0; second < 30; ++second) ASSERT_EQ(step(slave, second), fmi2OK);
  const double without_m = nose_m(slave);
  EXPECT_NE(without_m, with_factor_m);
  fmi2Component fresh = importer_->instantiate("fresh");
  begin(fresh);
  for (int second = 0; second < 30; ++second) ASSERT_EQ(step(fresh, second), fmi2OK);
  EXPECT_EQ(nose_m(fresh), without_m);
  FMI2_CALL(*importer_, fmi2FreeInstance)(slave);
  FMI2_CALL(*importer_, fmi2FreeInstance)(fresh);
}

TEST_F(Fmu, a_state_taken_and_serialised_leads_to_the_same_end) {
  fmi2Component slave = importer_->instantiate("spindle");
  begin(slave);
  for (int second = 0; second < 15; ++second) ASSERT_EQ(step(slave, second), fmi2OK);
  fmi2FMUstate state = nullptr;
  ASSERT_EQ(FMI2_CALL(*importer_, fmi2GetFMUstate)(slave, &state), fmi2OK);
  std::size_t size = 0;
  ASSERT_EQ(FMI2_CALL(*importer_, fmi2SerializedFMUstateSize)(slave, state, &size), fmi2OK);
  std::vector<fmi2Byte> bytes(size);
  ASSERT_EQ(FMI2_CALL(*importer_, fmi2SerializeFMUstate)(slave, state, bytes.data(), bytes.size()), fmi2OK);
  const double nose_then_m = nose_m(slave);
  std::vector<double> ends_m;
  for (int pass = 0; pass < 2; ++pass) {
    ASSERT_EQ(FMI2_CALL(*importer_, fmi2SetFMUstate)(slave, state), fmi2OK);
    EXPECT_EQ(nose_m(slave), nose_then_m);
    for (int second = 15; second < 30; ++second) ASSERT_EQ(step(slave, second), fmi2OK);
    ends_m.push_back(nose_m(slave));
    ASSERT_EQ(FMI2_CALL(*importer_, fmi2FreeFMUstate)(slave, &state), fmi2OK);
    ASSERT_EQ(FMI2_CALL(*importer_, fmi2DeSerializeFMUstate)(slave, bytes.data(), bytes.size(), &state), fmi2OK);
  }
  EXPECT_EQ(ends_m[0], ends_m[1]);
  EXPECT_NE(ends_m[0], nose_then_m);
  EXPECT_EQ(FMI2_CALL(*importer_, fmi2DeSerializeFMUstate)(slave, bytes.data(), bytes.size() - 1, &state), fmi2Error);
  FMI2_CALL(*importer_, fmi2FreeFMUstate)(slave, &state);
  FMI2_CALL(*importer_, fmi2FreeInstance)(slave);
}

TEST_F(Fmu, refuses_what_is_wrong_with_one_message) {
  const std::string resources = "file://" + importer_->folder + "/resources";
  EXPECT_EQ(importer_->instantiate("spindle", "{00000000-0000-0000-0000-000000000000}", resources), nullptr);
  ASSERT_EQ(importer_->messages.size(), 1u);
  EXPECT_NE(importer_->messages[0].find("guid"), std::string::npos) << importer_->messages[0];
  EXPECT_EQ(importer_->instantiate("spindle", importer_->guid, "file:///nowhere"), nullptr);
  EXPECT_EQ(importer_->messages.size(), 2u);

  fmi2Component slave = importer_->instantiate("spindle");
  const auto refused = [&](fmi2Status status, const std::string& word) {
    EXPECT_EQ(status, fmi2Error) << word;
    ASSERT_FALSE(importer_->messages.empty());
    EXPECT_NE(importer_->messages.back().find(word), std::string::npos) << importer_->messages.back();
  };
  const std::string environment = "environment." + network_.boundaries.environments[0].name;
  refused(importer_->set(slave, environment, -1.0), "above 0 K");
  refused(importer_->set(slave, "speed", std::numeric_limits<double>::quiet_NaN()), "finite");
  refused(importer_->set(slave, importer_->outputs[0], 1.0), "output");
  const fmi2ValueReference none = 1u << 20;
  double value = 0.0;
  refused(FMI2_CALL(*importer_, fmi2GetReal)(slave, &none, 1, &value), "does not exist");
  refused(step(slave, 0), "initialisation");
  begin(slave);
  refused(importer_->set(slave, "start_temperature", 300.0), "initialisation");
  refused(step(slave, 5), "last step");
  refused(FMI2_CALL(*importer_, fmi2DoStep)(slave, 0.0, -1.0, 1), "above 0 s");
  EXPECT_EQ(step(slave, 0), fmi2OK);
  FMI2_CALL(*importer_, fmi2FreeInstance)(slave);
}

TEST_F(Fmu, the_description_names_every_input_and_output_with_its_unit) {
  EXPECT_EQ(importer_->units.at("speed"), "rpm");
  EXPECT_EQ(importer_->starts.at("speed"), network_.boundaries.operating.speed_rpm);
  EXPECT_EQ(importer_->units.at("deformation." + network_.deformations[0].name), "m");
  EXPECT_EQ(importer_->outputs.size(), network_.key_points.size() + 2 * network_.parts.size() +
                                           network_.deformations.size() + network_.contact_pressures.size() +
                                           network_.boundaries.sources.size());
  // The same network gives the same file.
  const std::string again = path_ + ".again";
  write_fmu(network_, rom::encode_network(network_), again);
  EXPECT_EQ(rom::read_whole_file(path_, 1u << 28), rom::read_whole_file(again, 1u << 28));
}

}  // namespace fmu_test
}  // namespace spindle_twin::host_tools::tests
