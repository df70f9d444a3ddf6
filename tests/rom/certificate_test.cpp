#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "rom/file/rom_file.hpp"
#include "rom/integrate/output_uncertainty.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace certificate_test {

Network certified() {
  Network network = make_synthetic_network({2, 2, 2, true}, 7);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  network.contact_pressures = {{"fit", 2e6, Eigen::VectorXd::Zero(n)}};
  Certificate& certificate = network.certificate;
  certificate.box = {0.1, 10.0, 0.2, 5.0, 24000.0};
  certificate.mesh_size_m = 0.003;
  certificate.fe_unknowns = 43210;
  certificate.key_points_K = {{0.03, 0.01, 0.002}, {0.02, 0.015, 0.004}};
  certificate.part_means_K = {{0.01, 0.002, 0.0}, {0.02, 0.004, 0.001}};
  certificate.part_maxima_K = {{0.2, 0.1, 0.05}, {0.11, 0.07, 0.03}};
  certificate.deformations_m = {{1.5e-8, 6e-9, 5e-9}};
  certificate.contact_pressures_Pa = {{1200.0, 300.0, 80.0}};
  return network;
}

/// The same with a limit for each output, all of them different.
Network limited() {
  Network network = certified();
  Certificate& certificate = network.certificate;
  certificate.limit = {0.05, 0.04, 0.3};
  certificate.limit_rule = {0.95, 0.9, true};
  double next = 3e-8;
  for (std::vector<OutputError>* errors :
       {&certificate.key_points_K, &certificate.part_means_K, &certificate.part_maxima_K, &certificate.deformations_m,
        &certificate.contact_pressures_Pa}) {
    for (OutputError& error : *errors) error.limit = next *= 1.5;
  }
  return network;
}

TEST(Certificate, every_number_survives_the_file) {
  const Network network = limited();
  const Certificate& was = network.certificate;
  const Certificate is = decode_network(encode_network(network), "x.rom").certificate;
  EXPECT_EQ(is.seed, was.seed);
  EXPECT_EQ(is.cases, was.cases);
  EXPECT_EQ(is.box.contact_low, 0.1);
  EXPECT_EQ(is.box.contact_high, 10.0);
  EXPECT_EQ(is.box.film_low, 0.2);
  EXPECT_EQ(is.box.film_high, 5.0);
  EXPECT_EQ(is.box.speed_high_rpm, 24000.0);
  EXPECT_EQ(is.mesh_size_m, 0.003);
  EXPECT_EQ(is.fe_unknowns, 43210u);
  EXPECT_EQ(is.limit.key_points_K, 0.05);
  EXPECT_EQ(is.limit.nose_um, 0.04);
  EXPECT_EQ(is.limit.part_max_K, 0.3);
  EXPECT_EQ(is.limit_rule.content, 0.95);
  EXPECT_EQ(is.limit_rule.confidence, 0.9);
  EXPECT_TRUE(is.limit_rule.fitted);
  const auto same = [](const std::vector<OutputError>& a, const std::vector<OutputError>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].worst, b[i].worst);
      EXPECT_EQ(a[i].median, b[i].median);
      EXPECT_EQ(a[i].mesh, b[i].mesh);
      EXPECT_EQ(a[i].limit, b[i].limit);
    }
  };
  same(is.key_points_K, was.key_points_K);
  same(is.part_means_K, was.part_means_K);
  same(is.part_maxima_K, was.part_maxima_K);
  same(is.deformations_m, was.deformations_m);
  same(is.contact_pressures_Pa, was.contact_pressures_Pa);
}

TEST(Certificate, what_a_search_of_a_single_case_found_survives_the_file) {
  Network network = limited();
  for (const std::uint32_t searched : {0U, 1U}) {
    network.certificate.searched = searched;
    network.certificate.worst_found = {0.031 * searched, 0.012 * searched, 0.21 * searched};
    const Certificate is = decode_network(encode_network(network), "x.rom").certificate;
    EXPECT_EQ(is.searched, searched);
    EXPECT_EQ(is.worst_found.key_points_K, 0.031 * searched);
    EXPECT_EQ(is.worst_found.nose_um, 0.012 * searched);
    EXPECT_EQ(is.worst_found.part_max_K, 0.21 * searched);
  }
}

TEST(Certificate, the_limit_is_two_sigma_and_the_mesh_one) {
  EXPECT_DOUBLE_EQ(certificate_deviation({1.0, 0.5, 0.3, 1.6}), std::hypot(0.8, 0.3));
  const Network network = limited();
  const double limit_m = network.certificate.deformations_m[0].limit;
  EXPECT_DOUBLE_EQ(output_uncertainty(network).deformations_m[0], std::hypot(0.5 * limit_m, 5e-9));
}

TEST(Certificate, without_a_limit_the_worst_is_two_sigma) {
  const OutputUncertainty sigma = output_uncertainty(certified());
  EXPECT_DOUBLE_EQ(sigma.key_points_K[1], std::hypot(0.01, 0.004));
  EXPECT_DOUBLE_EQ(sigma.part_means_K[1], std::hypot(0.01, 0.001));
  EXPECT_DOUBLE_EQ(sigma.part_maxima_K[0], std::hypot(0.1, 0.05));
  EXPECT_DOUBLE_EQ(sigma.deformations_m[0], std::hypot(7.5e-9, 5e-9));
  EXPECT_DOUBLE_EQ(sigma.contact_pressures_Pa[0], std::hypot(600.0, 80.0));
}

TEST(Certificate, none_means_that_nothing_is_known) {
  Network network = certified();
  network.certificate = {};
  network.hand_written = true;
  const Network read = decode_network(encode_network(network), "x.rom");
  EXPECT_TRUE(read.hand_written);
  const OutputUncertainty sigma = output_uncertainty(read);
  EXPECT_TRUE(sigma.key_points_K.array().isNaN().all());
  EXPECT_TRUE(sigma.deformations_m.array().isNaN().all());
}

TEST(Certificate, what_cannot_be_is_refused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Change = std::function<void(Network&)>;
  const std::vector<std::pair<std::string, Change>> cases = {
      {"certificate of the key points: has 1 errors for 2 outputs",
       [](Network& n) { n.certificate.key_points_K.pop_back(); }},
      {"certificate of the part means: has 3 errors for 2 outputs",
       [](Network& n) { n.certificate.part_means_K.push_back({}); }},
      {"certificate of the part maxima: must be finite and not negative",
       [&](Network& n) { n.certificate.part_maxima_K[1].mesh = nan; }},
      {"certificate of the deformations: must be finite and not negative",
       [](Network& n) { n.certificate.deformations_m[0].median = -1e-12; }},
      {"certificate of the contact pressures: has a median above the worst",
       [](Network& n) { n.certificate.contact_pressures_Pa[0].median = 1e9; }},
      {"certificate box: has a lower edge above the upper one", [](Network& n) { n.certificate.box.film_low = 6.0; }},
      {"certificate box: must be finite and not negative", [&](Network& n) { n.certificate.box.speed_high_rpm = nan; }},
      {"certificate mesh_size_m: must be finite", [](Network& n) { n.certificate.mesh_size_m = -1.0; }},
      {"certificate of the deformations: must be finite and not negative",
       [&](Network& n) { n.certificate.deformations_m[0].limit = nan; }},
      {"certificate of the key points: has a limit without saying which share of the cases keeps it",
       [](Network& n) { n.certificate.key_points_K[0].limit = 0.1; }},
      {"certificate limit: has a content or a confidence that is no share below 1",
       [](Network& n) { n.certificate.limit_rule.content = 1.0; }},
      {"certificate: of a hand-written network", [](Network& n) { n.hand_written = true; }},
  };
  for (const auto& [message, change] : cases) {
    Network network = certified();
    change(network);
    std::string said;
    try {
      decode_network(encode_network(network), "x.rom");
    } catch (const InputError& error) {
      said = error.what();
    }
    EXPECT_NE(said.find("x.rom: " + message), std::string::npos) << "'" << said << "', expected '" << message << "'";
  }
}

}  // namespace certificate_test
}  // namespace spindle_twin::rom::tests
